#include "editor/preview/posed_buffers.h"

#include <epoxy/gl.h>

#include <cmath>
#include <string>
#include <string_view>

#include "editor/preview/gpu_times.h"
#include "pipeline/error.h"

namespace furrow::preview {
namespace {

using pipeline::Error;
using pipeline::Exit;

uint32_t layersWithWeights(std::span<const int16_t> weights, uint32_t stride) {
  uint32_t layers = 0;
  for (size_t i = 0; i < weights.size(); i += stride)
    for (uint32_t l = 0; l < stride; ++l) layers |= uint32_t{weights[i + l] != 0} << l;
  return layers;
}

}  // namespace

UploadedFrame::UploadedFrame(const AssetView& asset) : frame_(asset) {
  for (GlObject& buffer : buffers_) buffer = GlObject(GlKind::kBuffer);
}

PosedBuffers UploadedFrame::run(const FrameInput& input, StageTimes* times) {
  frame_.run(input, times);
  StageClock clock(times);
  const size_t stride = frame_.weights.size() / std::max<size_t>(frame_.positions.size(), 1);
  refill(buffers_[0], std::as_bytes(std::span(frame_.positions)));
  refill(buffers_[1], std::as_bytes(std::span(frame_.normals)));
  refill(buffers_[2], std::as_bytes(std::span(frame_.tangents)));
  refill(buffers_[3], std::as_bytes(std::span(frame_.weights)));
  clock.end("upload");
  return {buffers_[0], buffers_[1], buffers_[2], buffers_[3],
          layersWithWeights(frame_.weights, static_cast<uint32_t>(stride))};
}

GpuFrame::GpuFrame(const AssetView& asset, gl::Tier tier, gl::ResetStatus lost)
    : plan_(asset, {.form = gl::formOf(tier)}), generation_(objectGeneration()) {
  if (const Status status = executor_.create(plan_, lost); !status.ok())
    throw Error(status.code == StatusCode::kOutOfMemory || status.code == StatusCode::kUnavailable
                    ? Exit::kEnvironment
                    : Exit::kBadData,
                std::string(gl::tierName(tier)) + " tier", status.message, "use the cpu tier");
}

GpuFrame::~GpuFrame() {
  if (generation_ != objectGeneration()) executor_.giveUp();
}

Status GpuFrame::run(const FrameInput& input, StageTimes* times, PosedBuffers& out) {
  GpuTimes clock(times);
  Status status = executor_.upload(input);
  clock.end("upload");
  if (status.ok())
    status = executor_.run({}, [&](const Item& item) {
      constexpr std::string_view kPrefix = "furrow ";
      std::string_view name = item.label;
      if (name.starts_with(kPrefix)) name.remove_prefix(kPrefix.size());
      clock.end(name);
    });
  if (!status.ok()) return status;
  clock.read();
  out = {executor_.handle(Buffer::kPositions), executor_.handle(Buffer::kNormals),
         executor_.handle(Buffer::kTangents), executor_.handle(Buffer::kWeights)};
  return {};
}

}  // namespace furrow::preview
