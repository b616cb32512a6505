#include "editor/preview/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace furrow::preview {

namespace {

constexpr float kMargin = 1.06f;
// Depth range about the target, in distances from it.
constexpr float kNear = 0.02f, kFar = 50.0f;

void orient(const Camera& camera, CameraFrame& frame) {
  const float yaw = glm::radians(camera.yaw), pitch = glm::radians(camera.pitch);
  frame.back = {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
  frame.up = {-std::sin(yaw) * std::sin(pitch), std::cos(pitch), -std::cos(yaw) * std::sin(pitch)};
  frame.right = glm::cross(frame.up, frame.back);
}

}  // namespace

CameraFrame cameraFrame(const Camera& camera, float aspect) {
  CameraFrame frame;
  orient(camera, frame);
  const glm::vec3 target(camera.target.x, camera.target.y, camera.target.z);
  frame.eye = target + camera.distance * frame.back;
  frame.view_projection = glm::perspective(glm::radians(camera.field_of_view), aspect,
                                           camera.distance * kNear, camera.distance * kFar) *
                          glm::lookAt(frame.eye, target, frame.up);
  return frame;
}

Camera fitCamera(std::span<const Float3> positions, float aspect, float yaw, float pitch) {
  Camera camera;
  camera.yaw = yaw;
  camera.pitch = pitch;
  CameraFrame frame;
  orient(camera, frame);
  const glm::mat3 view = glm::transpose(glm::mat3(frame.right, frame.up, frame.back));

  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const Float3& p : positions) {
    const glm::vec3 seen = view * glm::vec3(p.x, p.y, p.z);
    if (!std::isfinite(seen.x + seen.y + seen.z)) continue;
    low = glm::min(low, seen);
    high = glm::max(high, seen);
  }
  if (!(low.x <= high.x)) return camera;

  const glm::vec3 middle = 0.5f * (low + high);
  const float vertical = std::tan(glm::radians(camera.field_of_view) * 0.5f);
  float distance = 0.0f;
  for (const Float3& p : positions) {
    const glm::vec3 seen = view * glm::vec3(p.x, p.y, p.z) - middle;
    if (!std::isfinite(seen.x + seen.y + seen.z)) continue;
    const float reach = std::max(std::abs(seen.y), std::abs(seen.x) / aspect) * kMargin;
    distance = std::max(distance, seen.z + reach / vertical);
  }
  const glm::vec3 target = glm::transpose(view) * middle;
  camera.target = {target.x, target.y, target.z};
  camera.distance = distance > 0.0f ? distance : 1.0f;
  return camera;
}

}  // namespace furrow::preview
