#pragma once

// Programs of a frame plan's shaders.

#include <epoxy/gl.h>

#include "furrow/frame_plan.h"

namespace furrow::gl {

// Compiles and links the stages of an item; 0 and the first line of the log in `status` on failure. The units
// of its samplers and the slots of its uniform blocks are those of the bindings.
GLuint makeProgram(const Item& item, Status& status);

}  // namespace furrow::gl
