#pragma once

// What the samples look like, before they are made: pictures that the program carries (editor/ui/pictures).

#include <imgui.h>

#include "editor/preview/gl_objects.h"

namespace furrow::editor::ui {

inline constexpr float kSampleAspect = 4.0f / 3.0f;  // width over height

class SamplePictures {
 public:
  // Need the context of the screen, as drawing does.
  ImTextureID face() { return texture(0); }
  ImTextureID jacket() { return texture(1); }

 private:
  ImTextureID texture(int index);

  preview::GlObject textures_[2];
  uint32_t generation_ = 0;
};

}  // namespace furrow::editor::ui
