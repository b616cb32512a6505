#include <algorithm>
#include <cstdio>

#include "editor/cli/backend.h"
#include "editor/cli/commands.h"
#include "editor/cli/outputs.h"
#include "editor/cli/pose_options.h"
#include "furrow/gl/executor.h"
#include "pipeline/error.h"

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;

struct Options {
  AssetOptions asset;
  std::string out;
  PoseOptions pose;
};

struct Result {
  std::vector<Float3> positions;
  std::vector<float> q;  // layer-major, a point
  std::vector<int16_t> weights;
};

void require(const Status& status) {
  if (!status.ok()) throw Error(Exit::kBadUsage, "frame", status.message, "check the pose options");
}

Result runCpu(const AssetView& asset, const FrameInput& input) {
  Result result;
  const uint32_t vertices = asset.vertexCount();
  result.positions.resize(vertices);
  result.q.resize(size_t{asset.pointCount()} * asset.layerCount());
  result.weights.resize(size_t{vertices} * asset.weightStride());
  const DeformJob deform{&asset, input.palette, input.morph_weights, result.positions, {}, {}};
  require(deform.validate());
  deform.run(0, vertices);
  std::vector<float> triangle_q(asset.triangleCount());
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    const CompressJob compress{&asset, l, result.positions, input.scale, triangle_q};
    require(compress.validate());
    compress.run(0, asset.triangleCount());
    const std::span<float> q =
        std::span(result.q).subspan(size_t{l} * asset.pointCount(), asset.pointCount());
    const SmoothJob smooth{&asset, triangle_q, q};
    require(smooth.validate());
    smooth.run(0, asset.pointCount());
    const RespondJob respond{&asset, l, asset.layers[l].response, input.region_weights[l], q, result.weights};
    require(respond.validate());
    respond.run(0, vertices);
  }
  return result;
}

Result runGpu(const AssetView& asset, const FrameInput& input, gl::Tier tier) {
  const FramePlan plan(asset, {.form = gl::formOf(tier), .normals = false, .point_q = true});
  gl::Executor executor;
  if (const Status status = executor.create(plan); !status.ok())
    throw Error(Exit::kEnvironment, std::string("--backend ") + gl::tierName(tier), status.message,
                "use --backend cpu");
  Status status = executor.upload(input);
  if (status.ok()) status = executor.run();
  if (!status.ok()) throw preview::ContextLost(tier, status.message);
  Result result;
  result.positions.resize(asset.vertexCount());
  result.q.resize(size_t{asset.pointCount()} * asset.layerCount());
  result.weights.resize(size_t{asset.vertexCount()} * asset.weightStride());
  executor.read(Buffer::kPositions, std::as_writable_bytes(std::span(result.positions)));
  executor.read(Buffer::kPointQ, std::as_writable_bytes(std::span(result.q)));
  executor.read(Buffer::kWeights, std::as_writable_bytes(std::span(result.weights)));
  return result;
}

std::string csv(const AssetView& asset, const Result& result, const double* origin) {
  std::string text = "vertex,point,x,y,z";
  for (const Layer& layer : asset.layers)
    text += ",alpha_" + std::string(layer.name) + ",weight_" + std::string(layer.name);
  text += '\n';
  std::vector<uint32_t> asset_vertex(asset.vertexCount());
  for (uint32_t v = 0; v < asset.vertexCount(); ++v) asset_vertex[asset.source_vertex[v]] = v;
  char cell[160];
  for (uint32_t source = 0; source < asset.vertexCount(); ++source) {
    const uint32_t v = asset_vertex[source];
    const uint32_t point = asset.vertex_point[v];
    const Float3 p = result.positions[v];
    std::snprintf(cell, sizeof cell, "%u,%u,%.9g,%.9g,%.9g", source, point, p.x + origin[0], p.y + origin[1],
                  p.z + origin[2]);
    text += cell;
    for (uint32_t l = 0; l < asset.layerCount(); ++l) {
      const float q = result.q[size_t{l} * asset.pointCount() + point];
      std::snprintf(cell, sizeof cell, ",%.9g,%.9g", 1.0 / std::max(q, kMinQ),
                    result.weights[v * size_t{asset.weightStride()} + l] / 32767.0);
      text += cell;
    }
    text += '\n';
  }
  return text;
}

void run(const Options& options) {
  options.pose.validate();
  checkOutputs({options.out}, {options.asset.file, options.asset.recipe, options.pose.take});
  Backend backend(options.pose.backend);
  backend.require();
  const OpenedAsset opened = options.asset.open();
  const preview::PosedFrame frame = poseFrame(opened, options.pose);
  const AssetView& asset = opened.asset.view();
  const Result result = backend.run([&](gl::Tier tier) {
    return tier == gl::Tier::kCpu ? runCpu(asset, frame.input) : runGpu(asset, frame.input, tier);
  });
  const std::string text = csv(asset, result, frame.origin);
  if (options.out.empty())
    std::fwrite(text.data(), 1, text.size(), stdout);
  else
    writeText(options.out, text);
  finishPrinting();
  backend.report();
  printWarnings(options.asset.file, opened.warnings);
}

}  // namespace

Command addEval(CLI::App& app) {
  CLI::App* command = app.add_subcommand("eval", "Weights of every vertex in one pose, as CSV");
  const auto options = std::make_shared<Options>();
  options->asset.add(*command);
  command->add_option("-o,--output", options->out, "CSV file (default: standard output)")->check(requireName);
  options->pose.add(*command);
  return [options] { run(*options); };
}

}  // namespace furrow::cli
