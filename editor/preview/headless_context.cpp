#include "editor/preview/headless_context.h"

#include <epoxy/egl.h>
// epoxy/egl.h first: it brings the platform's EGL types.
#include <epoxy/gl.h>

#include <array>
#include <string>
#include <vector>

#include "pipeline/error.h"

namespace furrow::preview {

struct HeadlessContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

namespace {

std::vector<EGLDisplay> candidateDisplays() {
  std::vector<EGLDisplay> displays;
  if (!epoxy_has_egl()) return displays;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") &&
      (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
       epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base"))) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count))
      for (EGLint i = 0; i < count; ++i)
        displays.push_back(
            eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(i)], nullptr));
  }
  return displays;
}

// A current core context on `display`, the newest version it gives, or EGL_NO_CONTEXT and why.
EGLContext makeContext(EGLDisplay display, std::string& why) {
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) {
    why = "the display does not start";
    return EGL_NO_CONTEXT;
  }
  if (!eglBindAPI(EGL_OPENGL_API)) {
    why = "the display has no desktop OpenGL";
    return EGL_NO_CONTEXT;
  }
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) {
    why = "the display cannot draw without a surface";
    return EGL_NO_CONTEXT;
  }
  // No surface is ever made, so any config that renders desktop OpenGL will do.
  const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (!eglChooseConfig(display, config_attributes, &config, 1, &configs) || configs == 0) {
    why = "the display has no configuration for OpenGL";
    return EGL_NO_CONTEXT;
  }
  // Told of a reset where the driver can tell.
  constexpr EGLint kVersions[][2] = {{4, 5}, {4, 3}, {3, 3}};
  for (const auto& version : kVersions)
    for (const EGLint reset : {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_NONE}) {
      const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                   version[0],
                                   EGL_CONTEXT_MINOR_VERSION,
                                   version[1],
                                   EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                   EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                   reset,
                                   EGL_LOSE_CONTEXT_ON_RESET,
                                   EGL_NONE};
      const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
      if (context == EGL_NO_CONTEXT) continue;
      if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) return context;
      eglDestroyContext(display, context);
    }
  why = "the driver has no OpenGL 3.3 core";
  return EGL_NO_CONTEXT;
}

}  // namespace

HeadlessContext::HeadlessContext() : state_(std::make_unique<State>()) {
  std::string why = "there is no EGL with a surfaceless or a device display";
  for (const EGLDisplay display : candidateDisplays()) {
    state_->context = makeContext(display, why);
    if (state_->context != EGL_NO_CONTEXT) {
      state_->display = display;
      return;
    }
  }
  throw pipeline::Error(
      pipeline::Exit::kEnvironment, "OpenGL", "no context without a window: " + why,
      "install a driver with EGL (Mesa's libegl1 and libgl1-mesa-dri serve machines without a GPU), or use "
      "--backend cpu with --shading alpha");
}

// The display stays open: it is shared by the whole process, and closing it unloads the driver under other
// contexts.
HeadlessContext::~HeadlessContext() {
  if (eglGetCurrentContext() == state_->context)
    eglMakeCurrent(state_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(state_->display, state_->context);
}

}  // namespace furrow::preview
