#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "furrow/types.h"

namespace furrow::preview {

// Orbit around `target`; angles in degrees. Yaw 0 looks along -Z at the front of a subject that faces +Z,
// positive yaw walks round to its left (+X), positive pitch looks down on it. In a file where Z is up, the
// subject faces -Y.
struct Camera {
  Float3 target{0, 0, 0};
  float distance = 1.0f;  // > 0
  float yaw = 0.0f, pitch = 0.0f;
  float field_of_view = 30.0f;  // vertical, degrees
  bool z_up = false;
};

// From where a surface shows when nobody says: its front, yaw and pitch 0. A flat one (cloth laid on the
// floor, a terrain, a plate) that would be seen edge-on from there shows the side of its normals, a closed
// one its top.
struct Facing {
  float yaw = 0.0f, pitch = 0.0f;
};
Facing facing(std::span<const Float3> positions, std::span<const uint32_t> indices);

// Fits posed positions tightly into a picture of width / height `aspect`, with a margin. Positions that are
// not finite are left out.
Camera fitCamera(std::span<const Float3> positions, float aspect, float yaw, float pitch, bool z_up = false);

struct CameraFrame {
  glm::vec3 eye, right, up, back;  // unit axes; `back` leads from the target to the eye
  glm::mat4 view_projection;
};
CameraFrame cameraFrame(const Camera& camera, float aspect);

}  // namespace furrow::preview
