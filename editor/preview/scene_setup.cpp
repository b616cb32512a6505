#include "editor/preview/scene_setup.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "editor/preview/view_values.h"
#include "pipeline/error.h"

namespace furrow::preview {

namespace {

using pipeline::Error;
using pipeline::Exit;

constexpr float kStrokesAcross = 48.0f;  // strokes from the bottom of a picture to its top

// The colour that the part's own map has at a vertex, linear, blurred to a few texels.
glm::vec3 paintedColor(const AssetView& asset, const Part& part, uint32_t v) {
  if (part.base_maps == kAbsent || asset.base_maps[part.base_maps].color.slices == 0) return glm::vec3(1.0f);
  const BaseMaps& maps = asset.base_maps[part.base_maps];
  constexpr uint32_t kSide = 64;
  uint32_t level = 0;
  while (level + 1 < maps.color.levels && std::max(maps.color.width, maps.color.height) >> level > kSide)
    ++level;
  const auto texel = [&](uint32_t axis, uint32_t size) {
    const float* m = maps.color_uv + axis;
    const float at = m[0] * asset.uvs[v].x + m[2] * asset.uvs[v].y + m[4];
    const float within = wrapped(maps.color_wrap[axis], at) * static_cast<float>(std::max(size >> level, 1u));
    return std::min(static_cast<uint32_t>(std::max(0.0f, within)), std::max(size >> level, 1u) - 1);
  };
  const Float4 c = texelAt(maps.color, level, 0, texel(0, maps.color.width), texel(1, maps.color.height));
  const auto linear = [](float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
  };
  return {linear(c.x), linear(c.y), linear(c.z)};
}

}  // namespace

// Like a photographer: a subject of bright albedo gets less light into the picture, so that its form is not
// burnt out; dark ones stay dark. The mean is that of the vertices.
float exposureOf(const AssetView& asset) {
  constexpr float kAlbedo = 0.38f;  // that is exposed as it is
  const glm::vec3 luminance(0.2126f, 0.7152f, 0.0722f);
  double sum = 0.0;
  for (const Part& part : asset.parts) {
    const glm::vec3 albedo = glm::vec3(shownColor(asset, part)) * luminance;
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v)
      sum += double{glm::dot(vertexColor(asset, v) * paintedColor(asset, part, v), albedo)};
  }
  const double mean = sum / std::max(asset.vertexCount(), 1u);
  return static_cast<float>(mean > kAlbedo ? kAlbedo / mean : 1.0);
}

void checkPicture(const AssetView& asset, const FrameInput& input, const RenderOptions& options) {
  const auto fail = [](const std::string& wrong) {
    throw Error(Exit::kBadUsage, "frame", wrong, "pass an input made for this asset");
  };
  if (input.palette.size() != asset.palette.size()) fail("the number of palette matrices is not the asset's");
  if (input.morph_weights.size() != asset.morphs.size())
    fail("the number of morph weights is not the asset's");
  if (!input.region_weights.empty() && input.region_weights.size() != asset.layers.size())
    fail("the number of region weights is not that of the layers");
  if (!input.responses.empty() && input.responses.size() != asset.layers.size())
    fail("the number of responses is not that of the layers");
  if (!(input.scale > 0.0f) || !std::isfinite(input.scale)) fail("the scale is not above 0");
  if ((!options.bias.empty() && options.bias.size() != asset.vertexCount()) ||
      (!options.directions.empty() && options.directions.size() != asset.vertexCount()))
    fail("the number of painted values is not that of the vertices");
  if (options.mask &&
      std::ranges::any_of(options.mask_parts, [&](uint32_t part) { return part >= asset.parts.size(); }))
    fail("a part with a painted mask does not exist");
  const bool of_layer =
      options.mask || !options.bias.empty() ||
      (options.view != View::kBeauty && options.view != View::kPoint && options.view != View::kMorph);
  if (of_layer && options.layer >= asset.layerCount()) fail("the view's layer does not exist");
  const Camera& camera = options.camera;
  if (!(camera.distance > 0.0f) || !(camera.field_of_view > 0.0f) || !(camera.field_of_view < 180.0f))
    fail("the camera has no distance or no field of view");
}

gpu::Scene sceneOf(const RenderOptions& options, float exposure) {
  const float aspect = static_cast<float>(options.width) / static_cast<float>(options.height);
  const Camera& camera = options.camera;
  const CameraFrame frame = cameraFrame(camera, aspect);
  const glm::vec3 target_point(camera.target.x, camera.target.y, camera.target.z);
  const float half_height = camera.distance * std::tan(glm::radians(camera.field_of_view) * 0.5f);
  const float turn = glm::radians(options.light_yaw);
  const glm::vec3 side = std::cos(turn) * frame.right - std::sin(turn) * frame.back;
  const glm::vec3 front = std::sin(turn) * frame.right + std::cos(turn) * frame.back;
  const auto light = [&](float right, float up, float back, float radiance) {
    return glm::vec4(glm::normalize(right * side + up * frame.up + back * front), radiance);
  };

  gpu::Scene scene{};
  scene.view_projection = frame.view_projection;
  scene.eye = glm::vec4(frame.eye, 0.0f);
  // The key grazes from the upper left, so that a crease in any direction but its own has a lit and a shaded
  // side.
  scene.lights[0] = light(-0.68f, 0.62f, 0.42f, 2.15f);
  scene.lights[1] = light(0.85f, 0.0f, 0.65f, 0.48f);
  scene.lights[2] = light(0.6f, 0.35f, -0.75f, 0.85f);
  scene.up = glm::vec4(frame.up, exposure);

  // The shadow map spans twice what the picture shows at the target, for what lies before and behind it;
  // casters before it are clamped onto it.
  const float reach = half_height * std::max(aspect, 1.0f) * 2.6f;
  const glm::vec3 key(scene.lights[0]);
  const glm::mat4 light_view = glm::lookAt(target_point + key * reach, target_point, side);
  const glm::mat4 light_projection = glm::ortho(-reach, reach, -reach, reach, 0.0f, reach * 2.0f);
  scene.shadow = glm::translate(glm::mat4(1.0f), glm::vec3(0.5f)) *
                 glm::scale(glm::mat4(1.0f), glm::vec3(0.5f)) * light_projection * light_view;
  scene.eye.w = 2.0f * reach / static_cast<float>(kShadowSize);

  const float spacing = 2.0f * half_height / kStrokesAcross;
  scene.size = {static_cast<float>(options.width), static_cast<float>(options.height),
                spacing * kStrokeLength, std::max(static_cast<float>(options.height) / 280.0f, 1.5f)};
  scene.layer = options.layer;
  return scene;
}

glm::vec4 shownColor(const AssetView& asset, const Part& part) {
  constexpr float kWhite = 0.98f;
  const Float4 base = part.base_color;
  const auto colored = [&] {
    return std::any_of(asset.colors.begin() + 4 * part.vertex_begin,
                       asset.colors.begin() + 4 * part.vertex_end, [](uint8_t c) { return c != 255; });
  };
  const bool painted = part.base_maps != kAbsent && asset.base_maps[part.base_maps].color.slices > 0;
  if (!painted && base.w >= 1.0f && base.x >= kWhite && base.y >= kWhite && base.z >= kWhite &&
      (asset.colors.empty() || !colored()))
    return {0.40f, 0.255f, 0.19f, 1.0f};
  return {base.x, base.y, base.z, base.w};
}

glm::vec3 vertexColor(const AssetView& asset, uint32_t v) {
  if (asset.colors.empty()) return glm::vec3(1.0f);
  const uint8_t* bytes = &asset.colors[size_t{4} * v];
  const glm::vec3 c = glm::vec3(bytes[0], bytes[1], bytes[2]) / 255.0f;
  return c * c;
}

std::vector<glm::vec4> shownValues(const AssetView& asset, const FrameInput& input,
                                   const RenderOptions& options) {
  std::vector<glm::vec4> shown;
  if (options.view == View::kPoint) shown = pointColors(asset);
  if (options.view == View::kBias) shown = biasValues(asset, options.layer);
  if (options.view == View::kDirection || options.view == View::kConfidence)
    shown = directionValues(asset, options.layer, options.directions);
  if (options.view == View::kMorph) shown = morphValues(asset, input.morph_weights);
  for (size_t v = 0; v < options.bias.size() && options.view == View::kBias; ++v)
    shown[v].x = options.bias[v];
  return shown;
}

}  // namespace furrow::preview
