#include "furrow/gl/tiered_frame.h"

#include <algorithm>
#include <cstdio>
#include <new>
#include <vector>

#include "furrow/cluster_frame.h"

namespace furrow::gl {

namespace {

// The cpu tier: posed by the jobs, weighed by the clustered frame, or with Laplacian steps by the staged one,
// on the calling thread.
class CpuTier {
 public:
  Status create(const AssetView& asset, const PlanOptions& options) {
    asset_ = &asset;
    options_ = options;
    staged_ = options.laplace_steps > 0;
    if (!staged_) {
      const Status status = clusters_.build(asset);
      staged_ = status.code == StatusCode::kUnavailable;  // clusters cannot hold it
      if (!status.ok() && !staged_) return status;
    }
    const size_t vertices = asset.vertexCount(), count = vertices * asset.weightStride();
    positions.resize(vertices);
    normals.resize(options.normals ? vertices : 0);
    tangents.resize(options.normals ? vertices : 0);
    weights.resize(count);
    state_.resize(options.ease ? count : 0);
    if (staged_) {
      triangle_q_.resize(asset.triangleCount());
      for (std::vector<float>& q : point_q_) q.resize(asset.pointCount());
    } else {
      scratch_.resize(clusters_.scratchBytes() + 64);
    }
    return {};
  }

  Status run(const FrameInput& input) {
    DeformJob deform{asset_, input.palette, input.morph_weights, positions, normals, tangents};
    deform.skinning = options_.skinning;
    deform.motions = input.motions;
    if (Status status = deform.validate(); !status.ok()) return status;
    deform.run(0, asset_->vertexCount());

    if (Status status = staged_ ? weighStaged(input) : weighClustered(input); !status.ok()) return status;

    constexpr Ease kAtOnce[kMaxLayers];
    EaseJob ease{asset_, {}, input.seconds, input.reset, input.fade, state_, weights};
    if (options_.ease)
      ease.eases = input.eases.empty() ? std::span(kAtOnce).first(asset_->layerCount()) : input.eases;
    if (Status status = ease.validate(); !status.ok()) return status;
    ease.run(0, asset_->vertexCount());
    return {};
  }

  std::vector<Float3> positions, normals;
  std::vector<Float4> tangents;
  std::vector<int16_t> weights;

 private:
  Status weighClustered(const FrameInput& input) {
    ClusterFrameJob frame;
    frame.clusters = &clusters_;
    frame.posed = reinterpret_cast<const std::byte*>(positions.data());
    frame.scale = input.scale;
    frame.responses = input.responses;
    frame.region_weights = input.region_weights;
    frame.active_layers = input.active_layers;
    frame.weights = weights;
    if (Status status = frame.validate(); !status.ok()) return status;
    void* memory = scratch_.data();
    size_t space = scratch_.size();
    std::align(64, clusters_.scratchBytes(), memory, space);
    frame.run(0, clusters_.count(), {static_cast<std::byte*>(memory), space});
    return {};
  }

  Status weighStaged(const FrameInput& input) {
    const uint32_t points = asset_->pointCount();
    std::fill(weights.begin(), weights.end(), int16_t{0});
    for (uint32_t l = 0; l < asset_->layerCount(); ++l) {
      if (!(input.active_layers >> l & 1u)) continue;
      const CompressJob compress{asset_, l, positions, input.scale, triangle_q_};
      if (Status status = compress.validate(); !status.ok()) return status;
      compress.run(0, asset_->triangleCount());
      SmoothJob{asset_, triangle_q_, point_q_[0]}.run(0, points);
      for (uint32_t step = 0; step < options_.laplace_steps; ++step) {
        LaplaceJob{asset_, triangle_q_, point_q_[0], input.laplace_rate, point_q_[1]}.run(0, points);
        std::swap(point_q_[0], point_q_[1]);
      }
      RespondJob{asset_,
                 l,
                 input.responses.empty() ? asset_->layers[l].response : input.responses[l],
                 input.region_weights.empty() ? 0.0f : input.region_weights[l],
                 point_q_[0],
                 weights}
          .run(0, asset_->vertexCount());
    }
    return {};
  }

  const AssetView* asset_ = nullptr;
  PlanOptions options_;
  bool staged_ = false;
  Clusters clusters_;
  std::vector<float> triangle_q_, point_q_[2];
  std::vector<float> state_;
  std::vector<std::byte> scratch_;
};

}  // namespace

struct TieredFrame::State {
  const AssetView* asset = nullptr;
  PlanOptions options;
  ResetStatus lost = nullptr;
  Tier tier = Tier::kCpu;
  char reason[192] = {};
  bool fresh = true;
  std::unique_ptr<FramePlan> plan;
  std::unique_ptr<Executor> executor;
  std::unique_ptr<CpuTier> cpu;

  // On failure there is neither executor nor cpu tier.
  Status start(Tier wanted) try {
    executor.reset();
    plan.reset();
    fresh = true;
    tier = wanted;
    if (tier == Tier::kCpu) {
      auto made = std::make_unique<CpuTier>();
      const Status status = made->create(*asset, options);
      if (status.ok()) cpu = std::move(made);
      return status;
    }
    options.form = formOf(tier);
    plan = std::make_unique<FramePlan>(*asset, options);
    auto made = std::make_unique<Executor>();
    const Status status = made->create(*plan, lost);
    if (status.ok()) executor = std::move(made);
    return status;
  } catch (const std::bad_alloc&) {
    return Status::error(StatusCode::kOutOfMemory, "out of memory");
  }

  // To the next tier that there is; the last one is tried again with each frame.
  Status fall() {
    for (;;)
      if (const Status status = start(nextTier(tier)); status.ok() || tier == Tier::kCpu) return status;
  }
};

TieredFrame::TieredFrame() = default;
TieredFrame::~TieredFrame() = default;

Status TieredFrame::create(const AssetView& asset, Tier tier, const PlanOptions& options,
                           ResetStatus lost) try {
  state_.reset();
  if (options.posed_by_host)
    return Status::error(StatusCode::kInvalidArgument, "a TieredFrame poses itself: no posed_by_host");
  state_ = std::make_unique<State>();
  state_->asset = &asset;
  state_->options = options;
  state_->options.instances = 1;
  state_->lost = lost;
  const Status status = state_->start(tier);
  if (!status.ok()) state_.reset();
  return status;
} catch (const std::bad_alloc&) {
  state_.reset();
  return Status::error(StatusCode::kOutOfMemory, "out of memory");
}

Status TieredFrame::run(const FrameInput& input) try {
  State& s = *state_;
  FrameInput now = input;
  now.reset = input.reset || s.fresh;
  if (!s.cpu && !s.executor)
    if (Status status = s.fall(); !status.ok()) return status;
  if (s.cpu) {
    const Status status = s.cpu->run(now);
    s.fresh = !status.ok();
    return status;
  }
  Status status = s.executor->upload(now);
  if (status.ok()) status = s.executor->run();
  s.fresh = !status.ok();
  if (status.ok()) return status;
  const Tier before = s.tier;
  s.fall();
  std::snprintf(s.reason, sizeof s.reason, "the %s tier ended: %.80s; frames run on the %s tier",
                tierName(before), status.message, tierName(s.tier));
  return Status::error(StatusCode::kUnavailable, "%s", s.reason);
} catch (const std::bad_alloc&) {
  return Status::error(StatusCode::kOutOfMemory, "out of memory");
}

Tier TieredFrame::tier() const {
  return state_->tier;
}

const char* TieredFrame::reason() const {
  return state_->reason;
}

const Executor* TieredFrame::executor() const {
  return state_->executor.get();
}

std::span<const Float3> TieredFrame::positions() const {
  return state_->cpu ? std::span<const Float3>(state_->cpu->positions) : std::span<const Float3>();
}

std::span<const Float3> TieredFrame::normals() const {
  return state_->cpu ? std::span<const Float3>(state_->cpu->normals) : std::span<const Float3>();
}

std::span<const Float4> TieredFrame::tangents() const {
  return state_->cpu ? std::span<const Float4>(state_->cpu->tangents) : std::span<const Float4>();
}

std::span<const int16_t> TieredFrame::weights() const {
  return state_->cpu ? std::span<const int16_t>(state_->cpu->weights) : std::span<const int16_t>();
}

}  // namespace furrow::gl
