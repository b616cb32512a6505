#include "editor/preview/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace furrow::preview {

namespace {

constexpr float kMargin = 1.06f;
// A surface whose normals lie along one line this much is flat; it is edge-on while that line leads this
// little to the front.
constexpr double kFlat = 0.85, kEdgeOn = 0.25;
constexpr int kPowerSteps = 40;
constexpr float kLargestPitch = 89.0f;
// Depth range about the target, in distances from it.
constexpr float kNear = 0.02f, kFar = 50.0f;

void orient(const Camera& camera, CameraFrame& frame) {
  const float yaw = glm::radians(camera.yaw), pitch = glm::radians(camera.pitch);
  frame.back = {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
  frame.up = {-std::sin(yaw) * std::sin(pitch), std::cos(pitch), -std::cos(yaw) * std::sin(pitch)};
  if (camera.z_up)
    for (glm::vec3* axis : {&frame.back, &frame.up}) *axis = {axis->x, -axis->z, axis->y};
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

Facing facing(std::span<const Float3> positions, std::span<const uint32_t> indices) {
  const auto at = [&](uint32_t v) { return glm::dvec3(positions[v].x, positions[v].y, positions[v].z); };
  glm::dvec3 sum(0.0);
  glm::dmat3 spread(0.0);  // of unit normals, by area
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const glm::dvec3 a = at(indices[i]);
    const glm::dvec3 normal = glm::cross(at(indices[i + 1]) - a, at(indices[i + 2]) - a);
    const double area = glm::length(normal);
    if (!std::isfinite(area) || area == 0.0) continue;
    sum += normal;
    spread += glm::outerProduct(normal, normal / area);
  }
  glm::dvec3 side(0.7, 0.7, 0.1);
  for (int i = 0; i < kPowerSteps; ++i) {
    const glm::dvec3 next = spread * side;
    if (!(glm::length(next) > 0.0)) return {};
    side = glm::normalize(next);
  }
  const double all = spread[0][0] + spread[1][1] + spread[2][2];
  if (glm::dot(side, spread * side) < kFlat * all || std::abs(side.z) > kEdgeOn) return {};
  const double outside = glm::dot(side, sum);  // of a closed plate none
  if (std::abs(outside) > 1e-3 * all ? outside < 0.0 : side.x + side.y < 0.0) side = -side;
  const auto degrees = [](double radians) { return static_cast<float>(glm::degrees(radians)); };
  const float pitch = degrees(std::asin(std::clamp(side.y, -1.0, 1.0)));
  return {std::abs(pitch) < kLargestPitch ? degrees(std::atan2(side.x, side.z)) : 0.0f,
          std::clamp(pitch, -kLargestPitch, kLargestPitch)};
}

Camera fitCamera(std::span<const Float3> positions, float aspect, float yaw, float pitch, bool z_up) {
  Camera camera;
  camera.yaw = yaw;
  camera.pitch = pitch;
  camera.z_up = z_up;
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
