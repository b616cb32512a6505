#include "furrow/gl/context.h"

#include <epoxy/gl.h>

namespace furrow::gl {

ResetStatus resetStatus() {
  if (epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness"))
    return [] { return uint32_t{glGetGraphicsResetStatus()}; };
  return [] { return uint32_t{GL_NO_ERROR}; };
}

Status contextStatus(ResetStatus asked, uint32_t buffer) {
  const GLenum reset = asked();
  if (reset == GL_NO_ERROR && glIsBuffer(buffer)) return {};
  return Status::error(StatusCode::kUnavailable, "the OpenGL context was lost (%s)",
                       reset == GL_GUILTY_CONTEXT_RESET     ? "reset, through its own doing"
                       : reset == GL_INNOCENT_CONTEXT_RESET ? "reset, through no fault of its own"
                       : reset != GL_NO_ERROR               ? "reset"
                                                            : "its objects are gone");
}

}  // namespace furrow::gl
