#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "asset_header.h"
#include "furrow/asset.h"
#include "furrow/bind.h"
#include "furrow/cluster_frame.h"
#include "furrow/drivers.h"
#include "furrow/frame_plan.h"
#include "furrow/jobs.h"
#include "furrow/place_hash.h"
#include "pipeline/pack/rig_section.h"

namespace {

using namespace furrow;

constexpr uint32_t kMostVertices = 4096;  // of an asset that is posed, too

struct Pose {
  explicit Pose(const AssetView& asset) : morphs(asset.morphs.size(), 1.0f), regions(asset.layerCount()) {
    for (const PaletteEntry& entry : asset.palette) palette.push_back(entry.inverse_bind);
    driveRegions(asset, morphs, std::vector<float>(asset.layerCount()), regions);
  }
  std::vector<Affine> palette;
  std::vector<float> morphs, regions;
};

// A frame by the staged jobs; what comes out is not looked at, the sanitizers watch how.
void poseStaged(const AssetView& asset) {
  const Pose pose(asset);
  std::vector<Float3> positions(asset.vertexCount()), normals(asset.vertexCount());
  std::vector<Float4> tangents(asset.vertexCount());
  const DeformJob deform{&asset, pose.palette, pose.morphs, positions, normals, tangents};
  if (!deform.validate().ok()) return;
  deform.run(0, asset.vertexCount());
  std::vector<float> triangle_q(asset.triangleCount()), point_q(asset.pointCount());
  std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
  for (uint32_t layer = 0; layer < asset.layerCount(); ++layer) {
    CompressJob{&asset, layer, positions, 1.0f, triangle_q}.run(0, asset.triangleCount());
    SmoothJob{&asset, triangle_q, point_q}.run(0, asset.pointCount());
    RespondJob{&asset, layer, asset.layers[layer].response, pose.regions[layer], point_q, weights}.run(
        0, asset.vertexCount());
  }
}

void poseClusters(const Clusters& clusters) {
  const Pose pose(*clusters.asset);
  std::vector<int16_t> weights(size_t{clusters.asset->vertexCount()} * clusters.asset->weightStride());
  std::vector<std::byte> memory(clusters.scratchBytes() + 64);
  void* aligned = memory.data();
  size_t space = memory.size();
  std::align(64, clusters.scratchBytes(), aligned, space);
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.palette = pose.palette;
  job.morph_weights = pose.morphs;
  job.region_weights = pose.regions;
  job.weights = weights;
  if (job.validate().ok())
    job.run(0, clusters.count(), {static_cast<std::byte*>(aligned), clusters.scratchBytes()});
}

void bind(const AssetView& asset) {
  std::vector<uint32_t> points(asset.vertexCount());
  BindJob job{&asset, asset.positions, asset.indices, asset.parts.front().rest, 0.0f, {}, points};
  std::vector<uint32_t> scratch(job.scratchSize());
  job.scratch = scratch;
  if (job.validate().ok()) job.run();
}

}  // namespace

// A .furrow file: its header is made to fit its payload, so that the fuzzer gets past the checksum. It is
// refused, or can be posed, bound and played.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::vector<uint8_t> file(data, data + size);
  AssetHeader header{};
  if (size < sizeof header) return 0;
  std::memcpy(header.magic, kAssetMagic, sizeof header.magic);
  header.version = kFormatVersion;
  header.payload_bytes = size - sizeof header;
  header.payload_hash = XXH3_64bits_withSeed(data + sizeof header, size - sizeof header, kFormatVersion);
  std::memcpy(file.data(), &header, sizeof header);

  Asset asset;
  if (!asset.load(std::as_bytes(std::span(file))).ok()) return 0;
  const AssetView& view = asset.view();
  try {
    pipeline::readRig(view);
  } catch (const std::runtime_error&) {
  }
  if (view.vertexCount() > kMostVertices) return 0;
  poseStaged(view);
  bind(view);
  const FramePlan plan(view, PlanOptions{});
  Clusters clusters;
  if (clusters.build(view).ok()) poseClusters(clusters);
  return 0;
}
