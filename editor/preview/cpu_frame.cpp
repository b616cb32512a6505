#include "editor/preview/cpu_frame.h"

#include "furrow/jobs.h"
#include "pipeline/error.h"

namespace furrow::preview {

namespace {

template <typename Job>
void runJob(const Job& job, uint32_t items) {
  if (const Status status = job.validate(); !status.ok())
    throw pipeline::Error(pipeline::Exit::kBadUsage, "frame", status.message,
                          "pass an input made for this asset");
  job.run(0, items);
}

}  // namespace

CpuFrame::CpuFrame(const AssetView& asset)
    : positions(asset.vertexCount()),
      normals(asset.vertexCount()),
      tangents(asset.vertexCount()),
      weights(size_t{asset.vertexCount()} * asset.weightStride()),
      asset_(asset),
      triangle_q_(asset.triangleCount()),
      point_q_(asset.pointCount()) {}

void CpuFrame::run(const FrameInput& input, StageTimes* times) {
  StageClock clock(times);
  runJob(DeformJob{&asset_, input.palette, input.morph_weights, positions, normals, tangents},
         asset_.vertexCount());
  clock.end("deform");
  for (uint32_t layer = 0; layer < asset_.layerCount(); ++layer) {
    const Response& response =
        input.responses.empty() ? asset_.layers[layer].response : input.responses[layer];
    const float region = input.region_weights.empty() ? 0.0f : input.region_weights[layer];
    runJob(CompressJob{&asset_, layer, positions, input.scale, triangle_q_}, asset_.triangleCount());
    clock.end("compress");
    runJob(SmoothJob{&asset_, triangle_q_, point_q_}, asset_.pointCount());
    clock.end("smooth");
    runJob(RespondJob{&asset_, layer, response, region, point_q_, weights}, asset_.vertexCount());
    clock.end("respond");
  }
}

}  // namespace furrow::preview
