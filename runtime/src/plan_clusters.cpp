// The clustered form of a frame plan.

#include <numeric>

#include "furrow/cluster_frame.h"
#include "plan_bindings.h"
#include "shaders/layout.h"

namespace furrow {

namespace {

static_assert(kTriangleLanes == 16 && kRingLanes == 8);  // as cluster.comp has it

constexpr Binding kBindings[] = {storage(0, Buffer::kRestVertices, "rest_vertices"),
                                 storage(1, Buffer::kInfluences, "influences"),
                                 storage(2, Buffer::kVertexPoint, "vertex_point"),
                                 storage(3, Buffer::kPalette, "palette"),
                                 storage(4, Buffer::kMorphWeights, "morph_weights"),
                                 storage(5, Buffer::kClusterTable, "table"),
                                 storage(6, Buffer::kBias, "bias"),
                                 storage(7, Buffer::kClusterData, "data"),
                                 storage(8, Buffer::kFrame, "frames"),
                                 storage(9, Buffer::kInstances, "instances"),
                                 storage(10, Buffer::kPositions, "positions"),
                                 storage(11, Buffer::kNormals, "normals"),
                                 storage(12, Buffer::kTangents, "tangents"),
                                 storage(13, Buffer::kState, "state"),
                                 storage(14, Buffer::kWeights, "weights"),
                                 storage(15, Buffer::kPointQ, "point_q")};

// The morph targets of each cluster: the entries of AssetView::morph_entries, by target and then by slot.
class MorphTable {
 public:
  MorphTable(const AssetView& asset, std::vector<uint32_t>& table)
      : asset_(asset), table_(table), entries_(asset.morphs.size()) {}

  void add(std::span<const uint32_t> slot_vertex, size_t record) {
    const uint32_t first_entry = asset_.vertexCount() + 1;
    for (uint32_t s = 0; s < slot_vertex.size(); ++s)
      for (uint32_t i = asset_.morph_entries[slot_vertex[s]]; i < asset_.morph_entries[slot_vertex[s] + 1];
           ++i) {
        const uint32_t* entry = &asset_.morph_entries[first_entry + size_t{gpu::kEntryWords} * i];
        entries_[entry[3]].insert(entries_[entry[3]].end(), {entry[0], entry[1], entry[2], s});
      }
    const size_t runs = table_.size();
    for (uint32_t m = 0; m < entries_.size(); ++m)
      if (!entries_[m].empty()) table_.insert(table_.end(), {m, 0, 0});
    const size_t runs_end = table_.size();
    for (size_t run = runs; run < runs_end; run += gpu::kRunWords) {
      std::vector<uint32_t>& entries = entries_[table_[run]];
      table_[run + 1] = static_cast<uint32_t>(table_.size());
      table_.insert(table_.end(), entries.begin(), entries.end());
      table_[run + 2] = static_cast<uint32_t>(table_.size());
      entries.clear();
    }
    table_[record + gpu::kClusterRuns] = static_cast<uint32_t>(runs);
    table_[record + gpu::kClusterRunsEnd] = static_cast<uint32_t>(runs_end);
  }

 private:
  const AssetView& asset_;
  std::vector<uint32_t>& table_;
  std::vector<std::vector<uint32_t>> entries_;  // of the cluster at hand, by target
};

std::vector<uint32_t> clusterTable(const Clusters& clusters, bool posed_by_host) {
  const AssetView& asset = *clusters.asset;
  std::vector<uint32_t> table;
  for (size_t i = 0; i < clusters.clusters.size(); ++i) {
    const Cluster& c = clusters.clusters[i];
    table.insert(table.end(), {c.points, c.vertices, c.slots, c.triangles, c.slot_vertex, c.extra_point,
                               c.corners, c.chunks, c.covered, 0, 0});
    for (uint32_t l = 0; l < asset.layerCount(); ++l)
      table.push_back(clusters.layer_words[i * asset.layerCount() + l]);
  }
  if (posed_by_host || asset.morphs.empty()) return table;
  MorphTable morphs(asset, table);
  for (size_t i = 0; i < clusters.clusters.size(); ++i) {
    const Cluster& c = clusters.clusters[i];
    morphs.add({&clusters.words[c.slot_vertex], c.slots}, i * (gpu::kClusterWords + asset.layerCount()));
  }
  return table;
}

}  // namespace

bool FramePlan::addClustered() {
  Clusters clusters;
  const Status status =
      clusters.build(*asset_, {gpu::kClusterPointLimit, gpu::kClusterSlotLimit, gpu::kClusterTriangleLimit});
  constexpr uint32_t kMostGroups = 65535;  // in one dimension, as OpenGL and Vulkan guarantee
  if (!status.ok() || clusters.count() > kMostGroups || options_.instances > kMostGroups) return false;
  fillWords(Buffer::kClusterTable, "furrow cluster table", clusterTable(clusters, options_.posed_by_host));
  fillWords(Buffer::kClusterData, "furrow cluster data", {clusters.words.begin(), clusters.words.end()});
  std::vector<uint32_t> all(options_.instances);
  std::iota(all.begin(), all.end(), 0u);
  fillWords(Buffer::kInstances, "furrow instances", std::move(all));
  buffers_[static_cast<size_t>(Buffer::kInstances)].lifetime = Lifetime::kPerInstance;
  if (options_.point_q)
    add(Buffer::kPointQ, "furrow point q", Lifetime::kPerInstance,
        uint64_t{asset_->pointCount()} * asset_->layerCount() * sizeof(float));
  items_.push_back({.kind = ItemKind::kDispatch,
                    .label = "furrow clusters",
                    .shader = Shader::kCluster,
                    .groups = {clusters.count(), options_.instances},
                    .bindings = kBindings});
  items_.push_back({.kind = ItemKind::kBarrier, .label = "furrow clusters"});
  return true;
}

}  // namespace furrow
