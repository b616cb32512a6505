#pragma once

// Whether the current OpenGL context is still there: a driver can be reset or updated, a GPU pulled, a
// context destroyed.

#include <cstdint>

#include "furrow/status.h"

namespace furrow::gl {

// Whether the context was lost: 0 as long as it was not, a GL_..._CONTEXT_RESET after that.
using ResetStatus = uint32_t (*)();

// glGetGraphicsResetStatus, if the current context has it. It tells where the context was made to tell
// (EGL_EXT_create_context_robustness, GLFW_CONTEXT_ROBUSTNESS), and is 0 elsewhere.
ResetStatus resetStatus();

// kUnavailable if the context was lost, and how: `asked` says so, or `buffer`, a buffer object of it, is no
// more.
Status contextStatus(ResetStatus asked, uint32_t buffer);

}  // namespace furrow::gl
