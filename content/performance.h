#pragma once

#include "content/scene.h"

namespace furrow::content {

// Clip "performance": ten seconds of expressions, one after another, for the face at `node`.
Clip performance(uint32_t node);

}  // namespace furrow::content
