#include <algorithm>
#include <cmath>

#include "host_frame.h"

using namespace furrow;

namespace furrow {
namespace {

constexpr size_t kLine = 64;
constexpr uint32_t kFeatures = FURROW_KEEP_POSITIONS | FURROW_KEEP_NORMALS | FURROW_USE_DUAL_QUATERNIONS |
                               FURROW_USE_LAPLACE | FURROW_USE_RECAPTURE | FURROW_USE_EASE;

// Hands out a block piece by piece, or only adds up where there is none.
class Carver {
 public:
  explicit Carver(std::byte* memory) : memory_(memory) {}
  template <typename T>
  std::span<T> take(size_t count) {
    const size_t at = (used_ + kLine - 1) / kLine * kLine;
    used_ = at + count * sizeof(T);
    return memory_ ? std::span<T>(reinterpret_cast<T*>(memory_ + at), count) : std::span<T>();
  }
  size_t used() const { return used_; }

 private:
  std::byte* memory_;
  size_t used_ = 0;
};

uint32_t completed(uint32_t features) {
  if (features &
      (FURROW_USE_LAPLACE | FURROW_USE_RECAPTURE | FURROW_USE_DUAL_QUATERNIONS | FURROW_KEEP_NORMALS))
    features |= FURROW_KEEP_POSITIONS;
  return features;
}

Status readDesc(const FurrowInstanceDesc* desc, FurrowInstanceDesc& out) {
  out = {};
  if (!desc) return {};
  if (Status s = readStruct(desc, out, "desc"); !s.ok()) return s;
  if (out.features & ~kFeatures) return invalid("desc.features has an unknown feature");
  return {};
}

Status makeInstance(FurrowAsset& asset, uint32_t features, void* memory, size_t memory_bytes,
                    FurrowInstance** out) {
  const size_t bytes = layOut(asset, features, nullptr, nullptr);
  if (memory && (memory_bytes < bytes || reinterpret_cast<uintptr_t>(memory) % kLine != 0))
    return Status::error(StatusCode::kInvalidArgument,
                         "the instance needs %zu bytes of memory aligned to %zu, it was given %zu", bytes,
                         kLine, memory_bytes);
  const bool own = !memory;
  if (own) memory = asset.context.memory.allocate(bytes, kLine);
  layOut(asset, features, static_cast<std::byte*>(memory), out);
  (*out)->own_memory = own;
  furrow_asset_retain(&asset);
  return {};
}

// The eased weights that both assets know.
void keepEased(const FurrowInstance& from, FurrowInstance& to) {
  const AssetView &a = from.asset.view, &b = to.asset.view;
  if (from.fresh || to.eased.empty() || a.vertexCount() != b.vertexCount()) return;
  for (uint32_t l = 0; l < b.layerCount(); ++l)
    for (uint32_t k = 0; k < a.layerCount(); ++k) {
      if (a.layers[k].name != b.layers[l].name) continue;
      for (size_t v = 0; v < b.vertexCount(); ++v)
        to.eased[v * b.weightStride() + l] = from.eased[v * a.weightStride() + k];
      break;
    }
  to.fresh = false;
}

template <typename Write>
void readWeights(const FurrowInstance& instance, const FurrowReadDesc& desc, size_t vertices, size_t stride,
                 Write write) {
  const AssetView& view = instance.asset.view;
  for (size_t v = 0; v < vertices; ++v) {
    size_t from = v;
    if (desc.binding) {
      const uint32_t point = desc.binding->points[v];
      from = point < view.pointCount() ? view.point_vertex[point] : kAbsent;
    }
    std::byte* out = static_cast<std::byte*>(desc.out) + v * stride;
    for (uint32_t l = 0; l < desc.layer_count; ++l)
      write(
          out, l,
          from == kAbsent ? int16_t{0} : instance.weights[from * view.weightStride() + desc.layer_begin + l]);
  }
}

template <typename T>
void put(std::byte* out, uint32_t index, T value) {
  std::memcpy(out + index * sizeof value, &value, sizeof value);
}

Status read(const FurrowInstance& instance, FurrowReadDesc desc) {
  const AssetView& view = instance.asset.view;
  if (!desc.out) return invalid("desc.out is NULL");
  if (desc.format > FURROW_WEIGHTS_SNORM8) return invalid("desc.format is unknown");
  if (desc.binding && &desc.binding->asset != &instance.asset)
    return invalid("desc.binding is of another asset: bind the mesh to this one");
  const uint32_t layers = view.layerCount();
  if (desc.layer_begin >= layers || desc.layer_count > layers - desc.layer_begin)
    return Status::error(StatusCode::kInvalidArgument, "layers %u and %u more, the asset has %u",
                         desc.layer_begin, desc.layer_count, layers);
  if (desc.layer_count == 0) desc.layer_count = layers - desc.layer_begin;
  constexpr size_t kBytes[] = {sizeof(int16_t), sizeof(float), sizeof(int8_t)};
  const size_t each = kBytes[desc.format] * desc.layer_count;
  const size_t stride = desc.stride == 0 ? each : desc.stride;
  const size_t vertices = desc.binding ? desc.binding->vertexCount() : view.vertexCount();
  if (stride < each) return invalid("desc.stride is shorter than the layers of a vertex");
  if (vertices > 0 && (desc.bytes < each || (desc.bytes - each) / stride < vertices - 1))
    return Status::error(StatusCode::kInvalidArgument, "desc.bytes holds fewer than %zu vertices", vertices);
  if (desc.format == FURROW_WEIGHTS_SNORM16)
    readWeights(instance, desc, vertices, stride,
                [](std::byte* out, uint32_t l, int16_t w) { put(out, l, w); });
  else if (desc.format == FURROW_WEIGHTS_FLOAT)
    readWeights(instance, desc, vertices, stride, [](std::byte* out, uint32_t l, int16_t w) {
      put(out, l, static_cast<float>(w) * (1.0f / 32767.0f));
    });
  else
    readWeights(instance, desc, vertices, stride, [](std::byte* out, uint32_t l, int16_t w) {
      put(out, l, static_cast<int8_t>(std::lround(static_cast<float>(w) * (127.0f / 32767.0f))));
    });
  return {};
}

}  // namespace

size_t layOut(FurrowAsset& asset, uint32_t features, std::byte* memory, FurrowInstance** instance) {
  const AssetView& view = asset.view;
  features = completed(features);
  const bool clustered = asset.clusters.asset != nullptr;
  Carver carver(memory);
  const auto head = carver.take<FurrowInstance>(1);
  FurrowInstance nowhere(asset, features);
  FurrowInstance& out = memory ? *new (head.data()) FurrowInstance(asset, features) : nowhere;
  const size_t weights = size_t{view.vertexCount()} * view.weightStride();
  out.weights = carver.take<int16_t>(weights);
  if (features & FURROW_KEEP_POSITIONS || !clustered) out.positions = carver.take<Float3>(view.vertexCount());
  if (features & FURROW_KEEP_NORMALS) {
    out.normals = carver.take<Float3>(view.vertexCount());
    out.tangents = carver.take<Float4>(view.vertexCount());
  }
  if (features & FURROW_USE_DUAL_QUATERNIONS) out.motions = carver.take<JointMotion>(view.palette.size());
  out.morph_weights = carver.take<float>(view.morphs.size());
  out.occlusion_deltas = carver.take<std::span<const float>>(view.morphs.size());
  const bool staged = features & FURROW_USE_LAPLACE || !clustered;
  if (staged) {
    out.triangle_q = carver.take<float>(view.triangleCount());
    for (auto& q : out.point_q) q = carver.take<float>(view.pointCount());
  }
  if (features & FURROW_USE_EASE) out.eased = carver.take<float>(weights);
  if (features & FURROW_USE_RECAPTURE) {
    out.rest_positions = carver.take<Float3>(view.vertexCount());
    if (clustered) out.cluster_rest = carver.take<uint32_t>(asset.clusters.restWords());
  }
  if (features & FURROW_USE_RECAPTURE && staged) {
    size_t coefficients = 0;
    for (const Layer& layer : view.layers) coefficients += layer.coefficients.size();
    out.coefficients = carver.take<float>(coefficients);
    out.own_layers = carver.take<Layer>(view.layerCount());
  }
  if (clustered) {
    out.scratch_each = (asset.clusters.scratchBytes() + kLine - 1) / kLine * kLine;
    out.scratch = carver.take<std::byte>(out.scratch_each * asset.context.desc.workers);
  }
  out.bytes = carver.used();
  if (!memory) return out.bytes;
  std::fill(out.weights.begin(), out.weights.end(), int16_t{0});
  std::fill(out.morph_weights.begin(), out.morph_weights.end(), 0.0f);
  std::fill(out.eased.begin(), out.eased.end(), 0.0f);
  std::uninitialized_default_construct(out.own_layers.begin(), out.own_layers.end());
  std::uninitialized_default_construct(out.occlusion_deltas.begin(), out.occlusion_deltas.end());
  *instance = &out;
  return out.bytes;
}

}  // namespace furrow

size_t furrow_instance_memory(const FurrowAsset* asset, const FurrowInstanceDesc* desc) {
  FurrowInstanceDesc wanted;
  if (!asset || !readDesc(desc, wanted).ok()) return 0;
  return layOut(const_cast<FurrowAsset&>(*asset), wanted.features, nullptr, nullptr);
}

int32_t furrow_instance_create(FurrowAsset* asset, const FurrowInstanceDesc* desc, FurrowInstance** instance,
                               FurrowStatus* status) {
  if (instance) *instance = nullptr;
  return guarded(status, [&]() -> Status {
    if (!asset || !instance) return invalid(asset ? "instance is NULL" : "asset is NULL");
    FurrowInstanceDesc wanted;
    if (Status s = readDesc(desc, wanted); !s.ok()) return s;
    return makeInstance(*asset, wanted.features, wanted.memory, wanted.memory_bytes, instance);
  });
}

void furrow_instance_release(FurrowInstance* instance) {
  if (!instance) return;
  FurrowAsset& asset = instance->asset;
  const size_t bytes = instance->bytes;
  const bool own = instance->own_memory;
  instance->~FurrowInstance();
  if (own) asset.context.memory.deallocate(instance, bytes, kLine);
  furrow_asset_release(&asset);
}

FurrowAsset* furrow_instance_asset(const FurrowInstance* instance) {
  return instance ? &instance->asset : nullptr;
}

int32_t furrow_instance_frame(FurrowInstance* instance, const FurrowFrame* frame, FurrowFrameReport* report,
                              FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (!instance) return invalid("instance is NULL");
    FurrowFrame wanted;
    if (Status s = readStruct(frame, wanted, "frame"); !s.ok()) return s;
    FurrowFrameReport out = {};
    if (report)
      if (Status s = writeStruct(out, report); !s.ok()) return s;
    if (Status s = runFrame(*instance, wanted, out); !s.ok()) return s;
    return report ? writeStruct(out, report) : Status();
  });
}

int32_t furrow_instance_recapture(FurrowInstance* instance, const FurrowFrame* frame, FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (!instance) return invalid("instance is NULL");
    FurrowFrame wanted;
    if (Status s = readStruct(frame, wanted, "frame"); !s.ok()) return s;
    return recapture(*instance, wanted);
  });
}

int32_t furrow_instance_forget_rest(FurrowInstance* instance, FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (!instance) return invalid("instance is NULL");
    instance->recaptured = false;
    return {};
  });
}

int32_t furrow_instance_reload(FurrowInstance** instance, FurrowAsset* asset, void* memory,
                               size_t memory_bytes, FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (!instance || !*instance || !asset) return invalid(asset ? "instance is NULL" : "asset is NULL");
    FurrowInstance* old = *instance;
    FurrowInstance* made = nullptr;
    const auto begin = reinterpret_cast<uintptr_t>(memory), used = reinterpret_cast<uintptr_t>(old);
    if (memory && begin < used + old->bytes && used < begin + memory_bytes)
      return invalid("the memory is the old instance's, which is read until the new one stands");
    if (Status s = makeInstance(*asset, old->features, memory, memory_bytes, &made); !s.ok()) return s;
    keepEased(*old, *made);
    made->calls = old->calls;
    made->pending_seconds = old->pending_seconds;
    furrow_instance_release(old);
    *instance = made;
    return {};
  });
}

const int16_t* furrow_instance_weights(const FurrowInstance* instance) {
  return instance ? instance->weights.data() : nullptr;
}

const float* furrow_instance_positions(const FurrowInstance* instance) {
  return instance && !instance->positions.empty() ? &instance->positions.data()->x : nullptr;
}

const float* furrow_instance_normals(const FurrowInstance* instance) {
  return instance && !instance->normals.empty() ? &instance->normals.data()->x : nullptr;
}

const float* furrow_instance_tangents(const FurrowInstance* instance) {
  return instance && !instance->tangents.empty() ? &instance->tangents.data()->x : nullptr;
}

int32_t furrow_instance_read(const FurrowInstance* instance, const FurrowReadDesc* desc,
                             FurrowStatus* status) {
  return guarded(status, [&]() -> Status {
    if (!instance) return invalid("instance is NULL");
    FurrowReadDesc wanted;
    if (Status s = readStruct(desc, wanted, "desc"); !s.ok()) return s;
    return read(*instance, wanted);
  });
}
