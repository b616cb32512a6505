#include "editor/preview/software_picture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "editor/preview/cpu_frame.h"
#include "editor/preview/scene_setup.h"
#include "editor/preview/shaders/lighting.h"
#include "furrow/raster.h"
#include "pipeline/error.h"
#include "pipeline/parallel.h"

namespace furrow::preview {

namespace {

using pipeline::Error;
using pipeline::Exit;
using pipeline::Image;

glm::vec3 vec(Float3 p) {
  return {p.x, p.y, p.z};
}
Float3 float3(glm::vec3 p) {
  return {p.x, p.y, p.z};
}

// Runs the passes of a job whose inputs, outputs and size are set, in memory that it keeps.
class Rasteriser {
 public:
  explicit Rasteriser(uint32_t threads) : threads_(threads) {}

  void run(RasterJob job) {
    const AssetView& asset = *job.asset;
    const uint32_t batches = rasterBatches(asset.triangleCount()), tiles = rasterTiles(job.width, job.height);
    vertices_.resize(asset.vertexCount());
    bins_.resize(rasterBinWords(asset.triangleCount(), job.width, job.height));
    job.vertices = vertices_;
    job.bins = bins_;
    if (const Status status = job.validate(); !status.ok())
      throw Error(Exit::kBadUsage, "picture", status.message, "check the options of the picture");
    constexpr uint32_t kVertices = 4096;
    each((asset.vertexCount() + kVertices - 1) / kVertices,
         [&](uint32_t i) { job.project(i * kVertices, std::min((i + 1) * kVertices, asset.vertexCount())); });
    each(batches, [&](uint32_t i) { job.bin(i, i + 1); });
    each(tiles, [&](uint32_t i) {
      alignas(64) static thread_local std::byte scratch[kRasterScratchBytes];
      job.draw(i, i + 1, scratch);
    });
  }

 private:
  template <typename Run>
  void each(uint32_t count, const Run& run) const {
    pipeline::parallelFor(count, threads_, run);
  }

  uint32_t threads_;
  std::vector<RasterVertex> vertices_;
  std::vector<uint64_t> bins_;
};

void setMatrix(RasterJob& job, const glm::mat4& m) {
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) job.view_projection[4 * row + column] = m[column][row];
}

// Where the key light reaches, as the renderer's shadow map has it.
class Shadow {
 public:
  Shadow(const gpu::Scene& scene, const AssetView& asset, std::span<const Float3> positions,
         Rasteriser& rasteriser)
      : scene_(scene), depth_(size_t{kShadowSize} * kShadowSize) {
    RasterJob job;
    job.asset = &asset;
    job.positions = positions;
    job.width = job.height = kShadowSize;
    job.samples = 1;
    job.depth = depth_;
    // From the map's depths in [0, 1] to clip space, which also holds casters far before it.
    const glm::mat4 clip(glm::vec4(2, 0, 0, 0), glm::vec4(0, 2, 0, 0), glm::vec4(0, 0, 1.0f / kReach, 0),
                         glm::vec4(-1, -1, 1.0f - 1.0f / kReach, 1));
    setMatrix(job, clip * scene.shadow);
    rasteriser.run(job);
  }

  // 1 in full light, as surface_fragment.glsl has it. `normal`: unit, towards the eye.
  float at(glm::vec3 position, glm::vec3 normal) const {
    const float cosine = glm::dot(normal, glm::vec3(scene_.lights[0]));
    const float lift = scene_.eye.w * gpu::shadowLift(cosine);
    const glm::vec4 at = scene_.shadow * glm::vec4(position + normal * lift, 1.0f);
    float lit = 0.0f;
    for (float y : {-gpu::kShadowBlur, 0.0f, gpu::kShadowBlur})
      for (float x : {-gpu::kShadowBlur, 0.0f, gpu::kShadowBlur})
        lit += litAt(at.x * kShadowSize + x, (1.0f - at.y) * kShadowSize + y, at.z - 0.001f);
    return gpu::keyShare(lit / 9.0f, glm::vec2(at));
  }

 private:
  static constexpr float kReach = 8.0f;  // depths of the map before it

  // Of the four texels about x, y.
  float litAt(float x, float y, float depth) const {
    const float left = std::floor(x - 0.5f), top = std::floor(y - 0.5f);
    const auto lit = [&](float column, float row) {
      const auto c = static_cast<size_t>(std::fmin(std::fmax(column, 0.0f), kShadowSize - 1.0f));
      const auto r = static_cast<size_t>(std::fmin(std::fmax(row, 0.0f), kShadowSize - 1.0f));
      const float caster = (depth_[r * kShadowSize + c] - 1.0f) * kReach + 1.0f;
      return depth <= caster ? 1.0f : 0.0f;
    };
    const float fx = x - 0.5f - left, fy = y - 0.5f - top;
    return glm::mix(glm::mix(lit(left, top), lit(left + 1, top), fx),
                    glm::mix(lit(left, top + 1), lit(left + 1, top + 1), fx), fy);
  }

  const gpu::Scene& scene_;
  std::vector<float> depth_;
};

// A vertex: negative where its normal looks to the side from which its triangles are seen clockwise.
std::vector<float> facings(const AssetView& asset, const CpuFrame& frame) {
  std::vector<float> result(asset.vertexCount());
  for (size_t i = 0; i < asset.indices.size(); i += 3) {
    const uint32_t* corner = &asset.indices[i];
    const glm::vec3 p[3] = {vec(frame.positions[corner[0]]), vec(frame.positions[corner[1]]),
                            vec(frame.positions[corner[2]])};
    const glm::vec3 facet = glm::cross(p[1] - p[0], p[2] - p[0]);
    for (int k = 0; k < 3; ++k) result[corner[k]] += glm::dot(facet, vec(frame.normals[corner[k]]));
  }
  return result;
}

// A vertex's colour in a view of values.
glm::vec3 shownColorAt(const AssetView& asset, const CpuFrame& frame, const RenderOptions& options,
                       std::span<const glm::vec4> values, uint32_t v) {
  switch (options.view) {
    case View::kWeight:
      return gpu::diverging(
          static_cast<float>(frame.weights[size_t{v} * asset.weightStride() + options.layer]) / 32767.0f);
    case View::kMask: {
      const auto mask = asset.layers[options.layer].mask;
      return gpu::maskShown(mask.empty() ? 1.0f : static_cast<float>(mask[v]) / 255.0f);
    }
    case View::kBias:
    case View::kMorph:
      return gpu::diverging(values[v].x);
    case View::kPoint:
      return glm::vec3(values[v]);
    default:
      return gpu::heat(values[v].x);
  }
}

// Of both sides; gloss is empty where no map is to be put under it.
struct VertexColors {
  explicit VertexColors(size_t vertices, bool gloss = false)
      : front(vertices),
        back(vertices),
        front_gloss(gloss ? vertices : 0),
        back_gloss(gloss ? vertices : 0) {}
  std::vector<Float3> front, back, front_gloss, back_gloss;
};

VertexColors normals(const AssetView& asset, const CpuFrame& frame) {
  const std::vector<float> facing = facings(asset, frame);
  VertexColors result(asset.vertexCount());
  for (size_t v = 0; v < facing.size(); ++v) {
    const glm::vec3 n = vec(frame.normals[v]) * (facing[v] < 0.0f ? -1.0f : 1.0f);
    result.front[v] = float3(n);
    result.back[v] = float3(-n);
  }
  return result;
}

// `shade`: how much of the key light there is.
VertexColors litColors(const AssetView& asset, const FrameInput& input, const CpuFrame& frame,
                       const VertexColors& normals, const RenderOptions& options, const gpu::Scene& scene,
                       float shade) {
  const bool beauty = options.view == View::kBeauty;
  const std::vector<glm::vec4> values = shownValues(asset, input, options);
  VertexColors colors(asset.vertexCount(), beauty && !asset.base_maps.empty());
  for (const Part& part : asset.parts) {
    const glm::vec3 part_color(shownColor(asset, part));
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v) {
      const glm::vec3 to_eye = glm::vec3(scene.eye) - vec(frame.positions[v]);
      const glm::vec3 view = to_eye / std::max(glm::length(to_eye), 1e-20f);
      const glm::vec3 base = part_color * vertexColor(asset, v);
      const glm::vec3 shown = beauty ? base : shownColorAt(asset, frame, options, values, v);
      const auto light = [&](glm::vec3 form, std::vector<Float3>& lit, std::vector<Float3>& gloss) {
        if (!beauty) {
          lit[v] = float3(shown * gpu::viewLight(form, view, glm::vec3(scene.lights[0])));
          return;
        }
        const auto of = [&](glm::vec3 color) {
          const auto method = options.lighting == Lighting::kBlinn ? gpu::shadeBlinn : gpu::shade;
          return method(scene.lights, glm::vec3(scene.up), color, form, form, view, 1.0f, part.roughness,
                        shade);
        };
        const glm::vec3 all = of(base), reflected = gloss.empty() ? glm::vec3(0.0f) : of(glm::vec3(0.0f));
        lit[v] = float3(all - reflected);
        if (!gloss.empty()) gloss[v] = float3(reflected);
      };
      light(vec(normals.front[v]), colors.front, colors.front_gloss);
      light(vec(normals.back[v]), colors.back, colors.back_gloss);
    }
  }
  return colors;
}

// What share of the key light reaches each pixel, from the normals and depths that were drawn there.
std::vector<float> keyLight(const Shadow& shadow, const gpu::Scene& scene, std::span<const Float4> normals,
                            std::span<const float> depths, const RenderOptions& options, uint32_t threads) {
  const glm::dmat4 to_world = glm::inverse(glm::dmat4(scene.view_projection));
  std::vector<float> lit(normals.size(), 1.0f);
  pipeline::parallelFor(options.height, threads, [&](uint32_t y) {
    for (uint32_t x = 0; x < options.width; ++x) {
      const size_t i = size_t{y} * options.width + x;
      const glm::vec3 normal(normals[i].x, normals[i].y, normals[i].z);
      const float length = glm::length(normal);
      if (depths[i] >= 1.0f || !(length > 0.0f)) continue;
      const glm::dvec4 at = to_world * glm::dvec4((x + 0.5) / options.width * 2.0 - 1.0,
                                                  1.0 - (y + 0.5) / options.height * 2.0, depths[i], 1.0);
      lit[i] = shadow.at(glm::vec3(at) / static_cast<float>(at.w), normal / length);
    }
  });
  return lit;
}

float encoded(float linear) {
  const float c = std::clamp(linear, 0.0f, 1.0f);
  return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

// Over the background, sRGB-encoded.
Image finished(std::span<const Float4> drawn, const RenderOptions& options, float exposure,
               uint32_t threads) {
  Image image{options.width, options.height, 4, std::vector<float>(drawn.size() * 4, 1.0f)};
  const auto height = static_cast<float>(options.height);
  pipeline::parallelFor(options.height, threads, [&](uint32_t y) {
    for (uint32_t x = 0; x < options.width; ++x) {
      const Float4& p = drawn[size_t{y} * options.width + x];
      const glm::vec2 pixel(static_cast<float>(x) + 0.5f, height - static_cast<float>(y) - 0.5f);
      glm::vec3 color(0.0f);
      if (p.w > 0.0f) {
        color = glm::vec3(p.x, p.y, p.z) / p.w;
        if (options.view == View::kBeauty) color = gpu::toneMap(color * exposure);
      }
      if (p.w < 1.0f) color = glm::mix(gpu::backgroundColor(pixel, height), color, p.w);
      float* out = image.at(x, y);
      for (int c = 0; c < 3; ++c) out[c] = std::round(encoded(color[c]) * 255.0f) / 255.0f;
    }
  });
  return image;
}

}  // namespace

const char* whyNotInSoftware(const RenderOptions& options) {
  if (options.view == View::kDirection) return "the strokes of the direction view are drawn by OpenGL";
  if (options.view == View::kBeauty && options.shading != Shading::kAlpha &&
      options.shading != Shading::kNone)
    return "wrinkles with a normal a pixel are drawn by OpenGL";
  return nullptr;
}

Image softwarePicture(const AssetView& asset, const FrameInput& input, const RenderOptions& options,
                      uint32_t threads) {
  checkPicture(asset, input, options);
  if (const char* why = whyNotInSoftware(options))
    throw Error(Exit::kEnvironment, "picture", why, "use --shading alpha or none, or another view");
  CpuFrame frame(asset);
  frame.run(input);
  const gpu::Scene scene = sceneOf(options, exposureOf(asset));
  Rasteriser rasteriser(threads);
  RasterJob job;
  job.asset = &asset;
  job.positions = frame.positions;
  setMatrix(job, scene.view_projection);
  job.width = options.width;
  job.height = options.height;
  job.vertex_shade = gpu::kVertexShade;
  const auto draw = [&](const VertexColors& colors, std::span<float> depths = {}) {
    std::vector<Float4> picture(size_t{options.width} * options.height);
    job.colors = colors.front;
    job.back_colors = colors.back;
    job.gloss = colors.front_gloss;
    job.back_gloss = colors.back_gloss;
    job.picture = picture;
    job.depth = depths;
    rasteriser.run(job);
    return picture;
  };
  const VertexColors facing = normals(asset, frame);
  std::vector<float> lit;  // light is by vertex, but where it does not reach
  if (options.view == View::kBeauty) {
    std::vector<float> depths(size_t{options.width} * options.height);
    const std::vector<Float4> drawn = draw(facing, depths);
    lit = keyLight(Shadow(scene, asset, frame.positions, rasteriser), scene, drawn, depths, options, threads);
  }
  if (options.view == View::kBeauty && options.shading == Shading::kAlpha) job.weights = frame.weights;
  std::vector<Float4> drawn = draw(litColors(asset, input, frame, facing, options, scene, 1.0f));
  if (options.view == View::kBeauty) {
    const std::vector<Float4> dark = draw(litColors(asset, input, frame, facing, options, scene, 0.0f));
    for (size_t i = 0; i < drawn.size(); ++i) {
      drawn[i].x = glm::mix(dark[i].x, drawn[i].x, lit[i]);
      drawn[i].y = glm::mix(dark[i].y, drawn[i].y, lit[i]);
      drawn[i].z = glm::mix(dark[i].z, drawn[i].z, lit[i]);
    }
  }
  return finished(drawn, options, scene.up.w, threads);
}

}  // namespace furrow::preview
