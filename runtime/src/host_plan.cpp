#include <algorithm>
#include <cstring>
#include <vector>

#include "furrow/frame_plan.h"
#include "host_frame.h"

using namespace furrow;

struct FurrowPlan {
  FurrowPlan(FurrowAsset& of, const FurrowInstance* rest, const PlanOptions& options)
      : asset(of), view(of.view), plan(takeRest(rest), options) {
    furrow_asset_retain(&asset);
  }
  FurrowPlan(const FurrowPlan&) = delete;
  FurrowPlan& operator=(const FurrowPlan&) = delete;

  // The view, with coefficients of its own if the instance was recaptured.
  const AssetView& takeRest(const FurrowInstance* rest) {
    if (!rest || !rest->recaptured) return view;
    layers.assign(view.layers.begin(), view.layers.end());
    for (uint32_t l = 0; l < layers.size(); ++l) {
      std::vector<float>& own = coefficients.emplace_back(layers[l].coefficients.size());
      RecaptureJob{&view, l, rest->rest_positions, rest->rest_scale, own}.run(0, view.triangleCount());
      layers[l].coefficients = own;
    }
    view.layers = layers;
    return view;
  }

  FurrowAsset& asset;
  AssetView view;
  std::vector<std::vector<float>> coefficients;
  std::vector<Layer> layers;
  FramePlan plan;
};

namespace furrow {
namespace {

static_assert(static_cast<int>(Form::kClustered) == FURROW_FORM_CLUSTERED &&
              static_cast<int>(Form::kStaged) == FURROW_FORM_STAGED &&
              static_cast<int>(Form::kRaster) == FURROW_FORM_RASTER);
static_assert(static_cast<int>(ItemKind::kDispatch) == FURROW_ITEM_DISPATCH &&
              static_cast<int>(ItemKind::kDraw) == FURROW_ITEM_DRAW &&
              static_cast<int>(ItemKind::kClear) == FURROW_ITEM_CLEAR &&
              static_cast<int>(ItemKind::kBarrier) == FURROW_ITEM_BARRIER);
static_assert(static_cast<int>(Access::kUniform) == FURROW_ACCESS_UNIFORM &&
              static_cast<int>(Access::kStorage) == FURROW_ACCESS_STORAGE &&
              static_cast<int>(Access::kFloats) == FURROW_ACCESS_FLOATS &&
              static_cast<int>(Access::kWords) == FURROW_ACCESS_WORDS &&
              static_cast<int>(Access::kSums) == FURROW_ACCESS_SUMS &&
              static_cast<int>(Access::kIndices) == FURROW_ACCESS_INDICES &&
              static_cast<int>(Access::kCapture) == FURROW_ACCESS_CAPTURE &&
              static_cast<int>(Access::kOtherSums) == FURROW_ACCESS_OTHER_SUMS);

constexpr uint32_t kBuffers = static_cast<uint32_t>(Buffer::kCount);

// By role, from FURROW_BUFFER_FRAME on.
constexpr Buffer kRoles[] = {Buffer::kFrame,     Buffer::kPalette, Buffer::kMorphWeights, Buffer::kInstances,
                             Buffer::kPositions, Buffer::kNormals, Buffer::kTangents,     Buffer::kWeights};

uint32_t roleOf(Buffer buffer) {
  const auto at = std::find(std::begin(kRoles), std::end(kRoles), buffer);
  return at == std::end(kRoles) ? uint32_t{FURROW_BUFFER_INTERNAL}
                                : static_cast<uint32_t>(at - std::begin(kRoles)) + FURROW_BUFFER_FRAME;
}

Status readOptions(const FurrowPlanDesc& desc, PlanOptions& out) {
  if (desc.form > FURROW_FORM_RASTER) return invalid("desc.form is unknown");
  if (desc.skinning > FURROW_SKINNING_DUAL_QUATERNION) return invalid("desc.skinning is unknown");
  if (desc.instances > 65535) return invalid("desc.instances is above 65535");
  out.form = static_cast<Form>(desc.form);
  out.posed_by_host = desc.posed_by_host;
  out.normals = desc.normals;
  out.skinning = static_cast<Skinning>(desc.skinning);
  out.ease = desc.ease;
  out.instances = std::max(desc.instances, 1u);
  out.laplace_steps = desc.laplace_steps;
  if (desc.laplace_steps > kMostLaplaceSteps) return invalid("desc.laplace_steps is above 1000");
  return {};
}

template <typename Info, typename Fill>
int32_t describe(const FurrowPlan* plan, size_t index, size_t count, const char* what, Info* info,
                 FurrowStatus* status, Fill fill) {
  return guarded(status, [&]() -> Status {
    if (!plan) return invalid("plan is NULL");
    if (index >= count)
      return Status::error(StatusCode::kInvalidArgument, "%s %zu, there are %zu", what, index, count);
    Info value = {};
    fill(value);
    return writeStruct(value, info);
  });
}

std::span<const Item> itemsOf(const FurrowPlan* plan) {
  return plan ? plan->plan.items() : std::span<const Item>();
}

Status writeValues(const FurrowPlan& plan, const FurrowFrame& frame, std::span<std::byte> out) {
  FrameValues values;
  if (Status s = readValues(plan.asset.view, frame, values); !s.ok()) return s;
  if (Status s = checkLaplace(frame); !s.ok()) return s;
  if (frame.laplace_steps != plan.plan.options().laplace_steps)
    return Status::error(StatusCode::kInvalidArgument,
                         "frame.laplace_steps is %u: create the plan with as many, it makes %u",
                         frame.laplace_steps, plan.plan.options().laplace_steps);
  if (frame.eases && !plan.plan.options().ease)
    return invalid("frame.eases: create the plan with FurrowPlanDesc.ease");
  const size_t layers = plan.asset.view.layerCount();
  FrameInput input;
  input.region_weights = {values.regions, layers};
  input.responses = {values.responses, layers};
  input.scale = values.scale;
  input.eases = {values.eases, layers};
  input.seconds = frame.seconds;
  input.reset = frame.reset;
  input.fade = 1.0f - frame.fade_out;
  input.active_layers = values.active_layers;
  input.laplace_rate = laplaceRate(frame);
  plan.plan.writeFrame(input, out);
  return {};
}

Status writePalette(const FurrowPlan& plan, const FurrowFrame& frame, std::byte* out) {
  if (!frame.palette || frame.palette_count != plan.asset.view.palette.size())
    return Status::error(StatusCode::kInvalidArgument, "frame.palette_count is %u, the asset has %zu",
                         frame.palette ? frame.palette_count : 0, plan.asset.view.palette.size());
  const std::span palette(reinterpret_cast<const Affine*>(frame.palette), frame.palette_count);
  if (plan.plan.options().skinning == Skinning::kDualQuaternion)
    splitPalette(palette, {reinterpret_cast<JointMotion*>(out), palette.size()});
  else
    std::memcpy(out, palette.data(), palette.size_bytes());
  return {};
}

Status writeMorphs(const FurrowPlan& plan, const FurrowFrame& frame, std::span<std::byte> out) {
  FrameValues values;
  if (Status s = readValues(plan.asset.view, frame, values); !s.ok()) return s;
  FrameInput input;
  input.morph_weights = values.morph_weights;
  if (values.morph_weights.empty())
    std::fill(out.begin(), out.end(), std::byte{0});
  else
    plan.plan.writeMorphWeights(input, out);
  return {};
}

Status write(const FurrowPlan& plan, uint32_t role, const FurrowFrame& frame, void* out, size_t bytes) {
  if (role < FURROW_BUFFER_FRAME || role > FURROW_BUFFER_MORPH_WEIGHTS)
    return invalid("furrow_plan_write() does not write this buffer");
  const uint64_t need = plan.plan.instanceBytes(kRoles[role - FURROW_BUFFER_FRAME]);
  if (need == 0) return invalid("the plan does not use this buffer");
  if (!out || bytes < need || reinterpret_cast<uintptr_t>(out) % alignof(float) != 0)
    return Status::error(StatusCode::kInvalidArgument, "out needs %llu bytes aligned to 4, it has %zu",
                         static_cast<unsigned long long>(need), out ? bytes : 0);
  const std::span span(static_cast<std::byte*>(out), static_cast<size_t>(need));
  return role == FURROW_BUFFER_FRAME     ? writeValues(plan, frame, span)
         : role == FURROW_BUFFER_PALETTE ? writePalette(plan, frame, span.data())
                                         : writeMorphs(plan, frame, span);
}

}  // namespace
}  // namespace furrow

int32_t furrow_plan_create(FurrowAsset* asset, const FurrowPlanDesc* desc, FurrowPlan** plan,
                           FurrowStatus* status) {
  if (plan) *plan = nullptr;
  return guarded(status, [&]() -> Status {
    if (!asset || !plan) return invalid(asset ? "plan is NULL" : "asset is NULL");
    FurrowPlanDesc wanted;
    PlanOptions options;
    if (Status s = readStruct(desc, wanted, "desc"); !s.ok()) return s;
    if (Status s = readOptions(wanted, options); !s.ok()) return s;
    if (wanted.rest && &wanted.rest->asset != asset) return invalid("desc.rest is of another asset");
    *plan = create<FurrowPlan>(asset->context, *asset, wanted.rest, options);
    return {};
  });
}

void furrow_plan_release(FurrowPlan* plan) {
  if (!plan) return;
  FurrowAsset& asset = plan->asset;
  destroy(asset.context, plan);
  furrow_asset_release(&asset);
}

int32_t furrow_plan_info(const FurrowPlan* plan, FurrowPlanInfo* info, FurrowStatus* status) {
  return describe(plan, 0, 1, "plan", info, status, [&](FurrowPlanInfo& out) {
    const FramePlan& p = plan->plan;
    out.form = static_cast<uint32_t>(p.options().form);
    out.instances = p.options().instances;
    out.buffers = kBuffers;
    out.items = static_cast<uint32_t>(p.items().size());
    out.shaders = static_cast<uint32_t>(Shader::kCount);
    out.sums_width = p.sums().width;
    out.sums_height = p.sums().height;
    out.sums_slices = p.sums().slices;
    out.sums_images = p.sums().images;
    for (uint32_t i = 0; i < kBuffers; ++i) {
      const auto id = static_cast<Buffer>(i);
      if (p.buffer(id).lifetime == Lifetime::kPerInstance)
        out.instance_bytes += p.instanceBytes(id);
      else
        out.asset_bytes += p.buffer(id).bytes;
    }
  });
}

int32_t furrow_plan_buffer(const FurrowPlan* plan, uint32_t buffer, FurrowBufferInfo* info,
                           FurrowStatus* status) {
  return describe(plan, buffer, kBuffers, "buffer", info, status, [&](FurrowBufferInfo& out) {
    const auto id = static_cast<Buffer>(buffer);
    const BufferDesc& from = plan->plan.buffer(id);
    out.name = from.name ? from.name : "";
    out.role = roleOf(id);
    out.per_instance = from.lifetime == Lifetime::kPerInstance;
    out.bytes = from.bytes;
    out.instance_bytes = out.per_instance ? plan->plan.instanceBytes(id) : 0;
    out.initial = from.initial.empty() ? nullptr : from.initial.data();
  });
}

int32_t furrow_plan_item(const FurrowPlan* plan, uint32_t item, FurrowItemInfo* info, FurrowStatus* status) {
  const std::span<const Item> items = itemsOf(plan);
  return describe(plan, item, items.size(), "item", info, status, [&](FurrowItemInfo& out) {
    const Item& from = items[item];
    out.kind = static_cast<uint32_t>(from.kind);
    out.label = from.label ? from.label : "";
    out.shader = from.shader == Shader::kCount ? FURROW_NONE : static_cast<uint32_t>(from.shader);
    std::copy_n(from.groups, 2, out.groups);
    out.first = from.first;
    out.count = from.count;
    out.slice = from.slice;
    out.image = from.image;
    out.bindings = static_cast<uint32_t>(from.bindings.size());
    out.captured_count = static_cast<uint32_t>(from.captured.size());
    out.captured = from.captured.data();
  });
}

int32_t furrow_plan_binding(const FurrowPlan* plan, uint32_t item, uint32_t binding, FurrowBindingInfo* info,
                            FurrowStatus* status) {
  const std::span<const Item> items = itemsOf(plan);
  const std::span<const Binding> bindings =
      item < items.size() ? items[item].bindings : std::span<const Binding>();
  return describe(plan, binding, bindings.size(), "binding", info, status, [&](FurrowBindingInfo& out) {
    const Binding& from = bindings[binding];
    out.slot = from.slot;
    out.buffer = from.buffer == Buffer::kCount ? FURROW_NONE : static_cast<uint32_t>(from.buffer);
    out.access = static_cast<uint32_t>(from.access);
    out.name = from.name;
  });
}

int32_t furrow_shader_source(uint32_t shader, FurrowShaderSource* source, FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (shader >= static_cast<uint32_t>(Shader::kCount)) return invalid("the shader is unknown");
    const ShaderSource& from = shaderSource(static_cast<Shader>(shader));
    FurrowShaderSource value = {};
    value.compute = from.compute;
    value.vertex = from.vertex;
    value.geometry = from.geometry;
    value.fragment = from.fragment;
    value.hlsl = from.hlsl;
    value.spirv = from.spirv.data();
    value.spirv_bytes = from.spirv.size_bytes();
    return writeStruct(value, source);
  });
}

int32_t furrow_plan_write(const FurrowPlan* plan, uint32_t role, const FurrowFrame* frame, void* out,
                          size_t bytes, FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (!plan) return invalid("plan is NULL");
    FurrowFrame wanted;
    if (Status s = readStruct(frame, wanted, "frame"); !s.ok()) return s;
    return write(*plan, role, wanted, out, bytes);
  });
}
