// A frame of an instance: what the host handed in becomes jobs, which are all checked before the first one
// runs.

#include "host_frame.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "furrow/drivers.h"

namespace furrow {
namespace {

// Items of a job that are worth handing to another thread.
constexpr uint32_t kVertexGrain = 2048, kClusterGrain = 2;

template <typename Job>
bool parallelJob(const FurrowContext& context, const Job& job, uint32_t count) {
  return parallel(context, count, kVertexGrain,
                  [&](uint32_t begin, uint32_t end, uint32_t) { job.run(begin, end); });
}

Status missing(const char* what, const char* feature) {
  return Status::error(StatusCode::kInvalidArgument, "%s: create the instance with %s", what, feature);
}

// How the pose comes about, by one of these.
struct Pose {
  const std::byte* direct = nullptr;  // the host's own floats, as they are
  size_t stride = 0;
  bool by_clusters = false;  // a palette that the clustered frame poses on the way
  bool by_deform = false;
  std::span<const FurrowPosedMesh> meshes;  // into FurrowInstance::positions
  std::span<const Affine> palette;
};

// Everything a frame needs, checked.
struct Plan {
  Pose pose;
  FrameValues values;
  bool staged = false;
};

Status planMeshes(const FurrowInstance& instance, const FurrowFrame& frame, Pose& pose) {
  const AssetView& view = instance.asset.view;
  pose.meshes = {frame.meshes, frame.mesh_count};
  if (frame.mesh_count == 0) return invalid("frame.mesh_count is 0");
  if (frame.key_curve > FURROW_KEYS_QUADRATIC) return invalid("frame.key_curve is unknown");
  if (!std::isfinite(frame.key_time)) return invalid("frame.key_time is not finite");
  for (const FurrowPosedMesh& mesh : pose.meshes) {
    VertexStream from, to;
    if (Status s = readStream(mesh.from, "mesh.from", from); !s.ok()) return s;
    if (mesh.to.data)
      if (Status s = readStream(mesh.to, "mesh.to", to); !s.ok()) return s;
    if (mesh.binding && &mesh.binding->asset != &instance.asset)
      return invalid("mesh.binding is of another asset: bind the mesh to this one");
    if (!mesh.binding && frame.mesh_count > 1) return invalid("of several meshes, each needs its binding");
    PoseJob job;
    job.from = from, job.to = to;
    if (Status s = job.validate(); !s.ok()) return s;
    const uint32_t vertices = mesh.binding ? mesh.binding->vertexCount() : view.vertexCount();
    if (from.count() < vertices || (mesh.to.data && to.count() < vertices))
      return Status::error(StatusCode::kInvalidArgument, "a mesh's stream holds fewer than %u vertices",
                           vertices);
    if (!mesh.binding && !mesh.to.data && from.format == VertexFormat::kFloat3 &&
        from.stride % sizeof(float) == 0 && instance.positions.empty()) {
      pose.direct = from.bytes.data() + from.offset;
      pose.stride = from.stride;
      return {};
    }
  }
  if (instance.positions.empty())
    return missing("halves, bindings, key frames and odd strides", "FURROW_KEEP_POSITIONS");
  return {};
}

Status planPalette(const FurrowInstance& instance, const FurrowFrame& frame, bool staged, Pose& pose) {
  const AssetView& view = instance.asset.view;
  if (!frame.palette) return invalid("frame has neither palette nor meshes");
  if (frame.palette_count != view.palette.size())
    return Status::error(StatusCode::kInvalidArgument, "frame.palette_count is %u, the asset has %zu",
                         frame.palette_count, view.palette.size());
  if (frame.skinning > FURROW_SKINNING_DUAL_QUATERNION) return invalid("frame.skinning is unknown");
  pose.palette = {reinterpret_cast<const Affine*>(frame.palette), frame.palette_count};
  const bool dual = frame.skinning == FURROW_SKINNING_DUAL_QUATERNION;
  if (dual && instance.motions.empty())
    return missing("dual quaternion skinning", "FURROW_USE_DUAL_QUATERNIONS");
  pose.by_clusters = !dual && !staged && instance.normals.empty();
  pose.by_deform = !pose.by_clusters;
  return {};
}

Status planPose(FurrowInstance& instance, const FurrowFrame& frame, Plan& plan) {
  if (frame.palette && frame.meshes) return invalid("frame has both palette and meshes");
  return frame.meshes ? planMeshes(instance, frame, plan.pose)
                      : planPalette(instance, frame, plan.staged, plan.pose);
}

Status planStages(const FurrowInstance& instance, const FurrowFrame& frame) {
  if (frame.eases && instance.eased.empty()) return missing("attack and release", "FURROW_USE_EASE");
  if (Status s = checkLaplace(frame); !s.ok()) return s;
  if (frame.laplace_steps > 0 && instance.point_q[0].empty())
    return missing("Laplacian steps", "FURROW_USE_LAPLACE");
  if (frame.occlusion &&
      (!frame.occlusion_rest || (!frame.occlusion_deltas && !instance.asset.view.morphs.empty())))
    return invalid("frame.occlusion needs occlusion_rest and occlusion_deltas");
  return {};
}

std::span<const float> morphWeights(const FurrowInstance& instance, const Plan& plan) {
  return plan.values.morph_weights.empty() ? instance.morph_weights : plan.values.morph_weights;
}

// Brings the pose to FurrowInstance::positions, unless it is taken as it is.
bool runPose(FurrowInstance& instance, const FurrowFrame& frame, const Plan& plan) {
  const FurrowContext& context = instance.asset.context;
  const AssetView& view = instance.asset.view;
  const Pose& pose = plan.pose;
  bool sound = true;
  if (pose.by_deform) {
    DeformJob job;
    job.asset = &view;
    job.palette = pose.palette;
    job.morph_weights = morphWeights(instance, plan);
    job.positions = instance.positions;
    job.normals = instance.normals;
    job.tangents = instance.tangents;
    job.simd = context.simd;
    if (frame.skinning == FURROW_SKINNING_DUAL_QUATERNION) {
      splitPalette(pose.palette, instance.motions);
      job.skinning = Skinning::kDualQuaternion;
      job.motions = instance.motions;
    }
    sound = parallelJob(context, job, view.vertexCount());
  } else if (!pose.direct && !pose.by_clusters) {
    for (const FurrowPosedMesh& mesh : pose.meshes) {
      PoseJob job;
      readStream(mesh.from, "", job.from);
      if (mesh.to.data) readStream(mesh.to, "", job.to);
      job.time = frame.key_time;
      job.curve = static_cast<KeyCurve>(frame.key_curve);
      if (mesh.binding) job.element = mesh.binding->element;
      job.patch = &mesh != pose.meshes.data();
      job.out = instance.positions;
      sound = parallelJob(context, job, view.vertexCount()) && sound;
    }
  }
  return sound;
}

bool runClustered(FurrowInstance& instance, const Plan& plan) {
  const FurrowContext& context = instance.asset.context;
  ClusterFrameJob job;
  job.clusters = &instance.asset.clusters;
  if (plan.pose.by_clusters) {
    job.palette = plan.pose.palette;
    job.morph_weights = morphWeights(instance, plan);
    job.positions = instance.positions;
  } else if (plan.pose.direct) {
    job.posed = plan.pose.direct;
    job.posed_stride = plan.pose.stride;
  } else {
    job.posed = reinterpret_cast<const std::byte*>(instance.positions.data());
  }
  const uint32_t layers = instance.asset.view.layerCount();
  if (instance.recaptured) job.rest = instance.cluster_rest;
  job.scale = plan.values.scale;
  job.responses = {plan.values.responses, layers};
  job.region_weights = {plan.values.regions, layers};
  job.active_layers = plan.values.active_layers;
  job.weights = instance.weights;
  job.simd = context.simd;
  return parallel(
      context, job.clusters->count(), kClusterGrain, [&](uint32_t begin, uint32_t end, uint32_t worker) {
        job.run(begin, end, instance.scratch.subspan(worker * instance.scratch_each, instance.scratch_each));
      });
}

bool runStaged(FurrowInstance& instance, const FurrowFrame& frame, const Plan& plan) {
  const FurrowContext& context = instance.asset.context;
  const AssetView& view = instance.view();
  bool sound = true;
  const auto run = [&](const auto& job, uint32_t count) {
    sound = parallelJob(context, job, count) && sound;
  };
  for (uint32_t l = 0; l < view.layerCount(); ++l) {
    if (!(plan.values.active_layers >> l & 1u)) {
      for (size_t i = l; i < instance.weights.size(); i += view.weightStride()) instance.weights[i] = 0;
      continue;
    }
    run(CompressJob{&view, l, instance.positions, plan.values.scale, instance.triangle_q},
        view.triangleCount());
    run(SmoothJob{&view, instance.triangle_q, instance.point_q[0]}, view.pointCount());
    size_t from = 0;
    for (uint32_t step = 0; step < frame.laplace_steps; ++step, from = 1 - from)
      run(LaplaceJob{&view, instance.triangle_q, instance.point_q[from], laplaceRate(frame),
                     instance.point_q[1 - from]},
          view.pointCount());
    run(RespondJob{&view, l, plan.values.responses[l], plan.values.regions[l], instance.point_q[from],
                   instance.weights},
        view.vertexCount());
  }
  return sound;
}

bool runEase(FurrowInstance& instance, const FurrowFrame& frame, const Plan& plan) {
  if (instance.eased.empty() && frame.fade_out == 0.0f) return true;
  EaseJob job;
  job.asset = &instance.asset.view;
  if (!instance.eased.empty()) job.eases = {plan.values.eases, instance.asset.view.layerCount()};
  job.seconds = instance.pending_seconds;
  job.reset = frame.reset || instance.fresh;
  job.fade = 1.0f - frame.fade_out;
  job.state = instance.eased;
  job.weights = instance.weights;
  return parallelJob(instance.asset.context, job, instance.asset.view.vertexCount());
}

bool runOcclusion(FurrowInstance& instance, const FurrowFrame& frame, const Plan& plan) {
  if (!frame.occlusion) return true;
  const AssetView& view = instance.asset.view;
  for (size_t m = 0; m < view.morphs.size(); ++m) {
    const float* deltas = frame.occlusion_deltas[m];
    instance.occlusion_deltas[m] = {deltas, deltas ? view.morphs[m].vertices.size() : 0};
  }
  const OcclusionJob job{&view,
                         morphWeights(instance, plan),
                         {frame.occlusion_rest, view.vertexCount()},
                         instance.occlusion_deltas,
                         {frame.occlusion, view.vertexCount()}};
  return parallelJob(instance.asset.context, job, view.vertexCount());
}

}  // namespace

Status checkLaplace(const FurrowFrame& frame) {
  if (!(frame.laplace_rate >= 0.0f) || !(frame.laplace_rate <= 1.0f))
    return invalid("frame.laplace_rate is not between 0 and 1");
  if (frame.laplace_steps > kMostLaplaceSteps) return invalid("frame.laplace_steps is above 1000");
  return {};
}

Status readValues(const AssetView& view, const FurrowFrame& frame, FrameValues& out) {
  const size_t morphs = view.morphs.size();
  if (frame.morph_weights && frame.morph_count != morphs)
    return Status::error(StatusCode::kInvalidArgument, "frame.morph_count is %u, the asset has %zu",
                         frame.morph_count, morphs);
  if (frame.morph_weights) out.morph_weights = {frame.morph_weights, morphs};
  for (float weight : out.morph_weights)
    if (!std::isfinite(weight)) return invalid("a morph weight is not finite");
  out.scale = frame.scale == 0.0f ? 1.0f : frame.scale;
  if (!(out.scale > 0.0f) || !std::isfinite(out.scale)) return invalid("frame.scale is not positive");
  const uint32_t layers = view.layerCount();
  for (uint32_t l = 0; l < layers; ++l) {
    out.responses[l] = view.layers[l].response;
    if (frame.responses) {
      const FurrowResponse& r = frame.responses[l];
      if (r.curve > FURROW_CURVE_OAT) return invalid("a response's curve is unknown");
      out.responses[l] = {static_cast<Curve>(r.curve), r.lambda, r.beta, r.stretch_lambda, r.stretch_beta};
      for (float value : {r.lambda, r.beta, r.stretch_lambda, r.stretch_beta})
        if (!(value > 0.0f) || !std::isfinite(value))
          return invalid("a response's lambda and beta must be positive");
    }
    out.regions[l] = frame.region_weights ? frame.region_weights[l] : 0.0f;
    if (!std::isfinite(out.regions[l])) return invalid("a region weight is not finite");
    out.eases[l] = frame.eases ? Ease{frame.eases[l].attack, frame.eases[l].release} : Ease{};
  }
  if (!(frame.seconds >= 0.0f) || !std::isfinite(frame.seconds)) return invalid("frame.seconds is negative");
  if (!(frame.fade_out >= 0.0f) || !(frame.fade_out <= 1.0f))
    return invalid("frame.fade_out is not between 0 and 1");
  out.active_layers = ~frame.inactive_layers;
  const std::span regions(out.regions, layers);
  if (frame.ignore_drivers || !frame.morph_weights)
    for (float& region : regions) region = std::clamp(region, -1.0f, 1.0f);
  else
    driveRegions(view, out.morph_weights, regions, regions);
  return {};
}

Status runFrame(FurrowInstance& instance, const FurrowFrame& frame, FurrowFrameReport& report) {
  const uint64_t call = instance.calls + frame.phase;
  const bool due = frame.every < 2 || call % frame.every == 0 || frame.reset || instance.fresh;
  if (!due) {
    if (!(frame.seconds >= 0.0f) || !std::isfinite(frame.seconds))
      return invalid("frame.seconds is negative");
    ++instance.calls;
    instance.pending_seconds += frame.seconds;
    return {};
  }
  Plan plan;
  plan.staged = frame.laplace_steps > 0 || !instance.asset.clusters.asset;
  if (Status s = readValues(instance.asset.view, frame, plan.values); !s.ok()) return s;
  if (Status s = planPose(instance, frame, plan); !s.ok()) return s;
  if (Status s = planStages(instance, frame); !s.ok()) return s;
  if (plan.staged && plan.pose.direct) return missing("a staged frame", "FURROW_KEEP_POSITIONS");

  report.computed = 1;
  ++instance.calls;
  instance.pending_seconds += frame.seconds;
  if (frame.fade_out == 1.0f) {
    std::fill(instance.weights.begin(), instance.weights.end(), int16_t{0});
    instance.fresh = true;
    return {};
  }
  report.clustered = !plan.staged;
  bool sound = runPose(instance, frame, plan);
  sound = (plan.staged ? runStaged(instance, frame, plan) : runClustered(instance, plan)) && sound;
  sound = runEase(instance, frame, plan) && sound;
  sound = runOcclusion(instance, frame, plan) && sound;
  instance.fresh = false;
  instance.pending_seconds = 0.0f;
  return soundness(sound);
}

Status recapture(FurrowInstance& instance, const FurrowFrame& frame) {
  if (instance.rest_positions.empty()) return missing("recapture", "FURROW_USE_RECAPTURE");
  const FurrowContext& context = instance.asset.context;
  const AssetView& view = instance.asset.view;
  Plan plan;
  plan.staged = true;
  if (Status s = readValues(view, frame, plan.values); !s.ok()) return s;
  if (Status s = planPose(instance, frame, plan); !s.ok()) return s;
  // What the last frame left stays.
  const std::span<Float3> positions = std::exchange(instance.positions, instance.rest_positions);
  const std::span<Float3> normals = std::exchange(instance.normals, {});
  const std::span<Float4> tangents = std::exchange(instance.tangents, {});
  bool sound = runPose(instance, frame, plan);
  instance.positions = positions, instance.normals = normals, instance.tangents = tangents;
  instance.rest_scale = plan.values.scale;

  const ClusterRecaptureJob clusters{&instance.asset.clusters, instance.rest_positions, instance.rest_scale,
                                     instance.cluster_rest};
  if (!instance.cluster_rest.empty())
    sound = parallel(context, instance.asset.clusters.count(), kClusterGrain,
                     [&](uint32_t begin, uint32_t end, uint32_t) { clusters.run(begin, end); }) &&
            sound;
  size_t first = 0;
  for (uint32_t l = 0; l < instance.own_layers.size(); ++l) {
    const std::span<float> own = instance.coefficients.subspan(first, view.layers[l].coefficients.size());
    sound = parallelJob(context, RecaptureJob{&view, l, instance.rest_positions, instance.rest_scale, own},
                        view.triangleCount()) &&
            sound;
    instance.own_layers[l] = view.layers[l];
    instance.own_layers[l].coefficients = own;
    first += own.size();
  }
  instance.own_rest = view;
  instance.own_rest.layers = instance.own_layers;
  instance.recaptured = true;
  return soundness(sound);
}

}  // namespace furrow
