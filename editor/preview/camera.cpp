#include "editor/preview/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace furrow::preview {

namespace {

constexpr float kMargin = 1.06f;
// A surface whose areas add up to this much of their sum is a sheet; less than this of it seen from the front
// is edge-on.
constexpr double kSheet = 0.8, kEdgeOn = 0.25;
constexpr float kLargestPitch = 89.0f;
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

Facing facing(std::span<const Float3> positions, std::span<const uint32_t> indices) {
  const auto at = [&](uint32_t v) { return glm::dvec3(positions[v].x, positions[v].y, positions[v].z); };
  glm::dvec3 sum(0.0);
  double area = 0.0;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const glm::dvec3 a = at(indices[i]);
    const glm::dvec3 normal = glm::cross(at(indices[i + 1]) - a, at(indices[i + 2]) - a);
    if (!std::isfinite(normal.x + normal.y + normal.z)) continue;
    sum += normal;
    area += glm::length(normal);
  }
  const double length = glm::length(sum);
  if (!(length > kSheet * area) || std::abs(sum.z) > kEdgeOn * length) return {};
  const auto degrees = [](double radians) { return static_cast<float>(glm::degrees(radians)); };
  const float pitch = degrees(std::asin(sum.y / length));
  return {std::abs(pitch) < kLargestPitch ? degrees(std::atan2(sum.x, sum.z)) : 0.0f,
          std::clamp(pitch, -kLargestPitch, kLargestPitch)};
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
