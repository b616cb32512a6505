#include "furrow/gl/tier.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace furrow::gl {

namespace {

constexpr const char* kNames[] = {"gpu", "gpu-raster", "cpu"};
constexpr const char* kAuto = "auto";

}  // namespace

const char* tierName(Tier tier) {
  return kNames[static_cast<size_t>(tier)];
}

Tier nextTier(Tier tier) {
  return tier == Tier::kGpu ? Tier::kGpuRaster : Tier::kCpu;
}

Support querySupport() {
  Support support;
  const int version = epoxy_gl_version();
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const char* name = renderer ? renderer : "unknown renderer";
  support.gpu = epoxy_is_desktop_gl() && version >= 43;
  support.gpu_raster = epoxy_is_desktop_gl() && version >= 33;
  std::snprintf(support.reason, sizeof support.reason, "%s, OpenGL%s %d.%d%s", name,
                epoxy_is_desktop_gl() ? "" : " ES", version / 10, version % 10,
                support.gpu          ? ""
                : support.gpu_raster ? "; compute needs OpenGL 4.3"
                                     : "; the GPU tiers need OpenGL 3.3");
  return support;
}

Form formOf(Tier tier) {
  if (tier == Tier::kGpuRaster) return Form::kRaster;
  // Of shaders/cluster.comp. The memory that it shares is less than what OpenGL 4.3 asks of everyone.
  constexpr GLint kBuffers = 16;
  GLint buffers = 0;
  glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &buffers);
  return buffers >= kBuffers ? Form::kClustered : Form::kStaged;
}

Status wantedTier(std::string_view backend, std::string_view& wanted) {
  const char* said_by = "backend";
  if (backend.empty() || backend == kAuto) {
    backend = kAuto;
    if (const char* variable = std::getenv("FURROW_BACKEND"); variable && *variable) {
      backend = variable;
      said_by = "FURROW_BACKEND";
    }
  }
  for (const char* name : {kAuto, kNames[0], kNames[1], kNames[2]})
    if (backend == name) {
      wanted = name;
      return {};
    }
  return Status::error(StatusCode::kInvalidArgument, "%s is \"%.*s\" and not auto, gpu, gpu-raster or cpu",
                       said_by, static_cast<int>(std::min<size_t>(backend.size(), 60)), backend.data());
}

Status chooseTier(std::string_view wanted, std::string_view no_context, TierChoice& choice) {
  Support support;
  if (no_context.empty() && wanted != kNames[2])
    support = querySupport();
  else
    std::snprintf(support.reason, sizeof support.reason, "%.*s", static_cast<int>(no_context.size()),
                  no_context.data());
  const bool there[] = {support.gpu, support.gpu_raster, true};
  const bool forced = wanted != kAuto;
  for (size_t i = 0; i < 3; ++i) {
    if (forced && wanted != kNames[i]) continue;
    if (there[i]) {
      choice.tier = static_cast<Tier>(i);
      if (forced && i == 2)
        std::snprintf(choice.reason, sizeof choice.reason, "cpu, as asked for");
      else
        std::snprintf(choice.reason, sizeof choice.reason, "%s%s: %s", kNames[i],
                      forced ? ", as asked for" : "", support.reason);
      return {};
    }
    if (forced) break;
  }
  return Status::error(StatusCode::kUnavailable, "the %.*s tier is not available: %s",
                       static_cast<int>(wanted.size()), wanted.data(), support.reason);
}

}  // namespace furrow::gl
