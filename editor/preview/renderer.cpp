#include "editor/preview/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "editor/preview/asset_objects.h"
#include "editor/preview/gpu_times.h"
#include "editor/preview/posed_buffers.h"
#include "editor/preview/programs.h"
#include "editor/preview/scene_setup.h"
#include "editor/preview/view_values.h"
#include "furrow/raster.h"

namespace furrow::preview {
namespace {

using pipeline::Error;
using pipeline::Exit;

constexpr GLuint kVectors = kMaxLayers / 4;  // weights and masks go in fours

void bindTexture(GLint unit, GLenum kind, uint32_t texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(kind, texture);
}

void drawTriangles(uint32_t begin, uint32_t end) {
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * (end - begin)), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(size_t{begin} * 3 * sizeof(uint32_t)));
}

}  // namespace

struct Renderer::State {
  State();

  void show(const AssetView& shown);
  Status pose(const FrameInput& input, const RenderOptions& options, Tier tier, gl::ResetStatus lost,
              PosedBuffers& out);
  void bindSurface(const PosedBuffers& posed) const;
  void bindValues(const FrameInput& input, const RenderOptions& options);
  void takeMask(const RenderOptions& options);
  void fillScene(const RenderOptions& options, uint32_t weighed);
  void bindMaterial(size_t part) const;
  void drawShadow(const RenderOptions& options);
  void drawParts(const RenderOptions& options);
  void drawStrokes(const RenderOptions& options);

  // Of the context.
  const uint32_t generation = objectGeneration();
  Programs programs;
  GlObject vertex_array, values, stroke_indices, scene_buffer, shadow_map, shadow_frame, empty_map, mask_map;
  std::unique_ptr<PictureTarget> target;
  std::shared_ptr<const pipeline::ByteImage> mask;  // that is painted, in mask_map

  // Of the asset.
  std::vector<Layer> layers;
  AssetView asset;  // with `layers`
  std::unique_ptr<AssetObjects> objects;
  std::unique_ptr<UploadedFrame> cpu;
  std::unique_ptr<GpuFrame> gpu_frame, raster_frame;
  float exposure = 1.0f;

  // Of the picture.
  gpu::Scene scene{};
  float stroke_spacing = 0.0f;
  uint32_t stroke_layer = kAbsent;
  GLsizei strokes = 0;

 private:
  PosedBuffers poseOnCpu(const FrameInput& input, const RenderOptions& options);
  void makeShadowMap();
};

Renderer::State::State()
    : vertex_array(GlKind::kVertexArray),
      values(GlKind::kBuffer),
      stroke_indices(GlKind::kBuffer),
      scene_buffer(GlKind::kBuffer) {
  makeShadowMap();
  // A sampler must have a complete texture even where nothing is read from it.
  const std::array<std::byte, 4> texel{};
  empty_map = makeTexture({TextureFormat::kRgba8, 1, 1, 1, 1, texel});
  mask_map = GlObject(GlKind::kTexture);
  fillMask(mask_map, {1, 1, 1, {0}});
}

void Renderer::State::show(const AssetView& shown) {
  cpu.reset();
  gpu_frame.reset();
  raster_frame.reset();
  layers.assign(shown.layers.begin(), shown.layers.end());
  asset = shown;
  asset.layers = layers;
  objects = std::make_unique<AssetObjects>(asset, objects.get());
  exposure = exposureOf(asset);
  stroke_layer = kAbsent;
}

void Renderer::State::makeShadowMap() {
  shadow_map = GlObject(GlKind::kTexture);
  glBindTexture(GL_TEXTURE_2D, shadow_map);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, kShadowSize, kShadowSize, 0, GL_DEPTH_COMPONENT,
               GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  shadow_frame = GlObject(GlKind::kFramebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_frame);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map, 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

PosedBuffers Renderer::State::poseOnCpu(const FrameInput& input, const RenderOptions& options) {
  if (!cpu) cpu = std::make_unique<UploadedFrame>(asset);
  if (options.bias.empty()) return cpu->run(input, options.times);
  std::vector<int16_t> painted;
  for (const float value : options.bias)
    painted.push_back(static_cast<int16_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 32767.0f)));
  std::span<const int16_t>& bias = layers[options.layer].bias;
  const std::span<const int16_t> own = std::exchange(bias, painted);
  const PosedBuffers posed = cpu->run(input, options.times);
  bias = own;
  return posed;
}

Status Renderer::State::pose(const FrameInput& input, const RenderOptions& options, Tier tier,
                             gl::ResetStatus lost, PosedBuffers& out) {
  if (tier == Tier::kCpu) {
    out = poseOnCpu(input, options);
    return {};
  }
  std::unique_ptr<GpuFrame>& frame = tier == Tier::kGpu ? gpu_frame : raster_frame;
  if (!frame) frame = std::make_unique<GpuFrame>(asset, tier, lost);
  return frame->run(input, options.times, out);
}

void Renderer::State::bindSurface(const PosedBuffers& posed) const {
  glBindVertexArray(vertex_array);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects->indices);
  const auto attribute = [](GLuint slot, uint32_t buffer, GLint components, GLenum type, GLsizei stride,
                            size_t offset) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glVertexAttribPointer(slot, components, type, type != GL_FLOAT, stride,
                          reinterpret_cast<const void*>(offset));
    glEnableVertexAttribArray(slot);
  };
  attribute(kPosition, posed.positions, 3, GL_FLOAT, sizeof(Float3), 0);
  attribute(kNormal, posed.normals, 3, GL_FLOAT, sizeof(Float3), 0);
  attribute(kTangent, posed.tangents, 4, GL_FLOAT, sizeof(Float4), 0);
  attribute(kUv, objects->uvs, 2, GL_FLOAT, sizeof(Float2), 0);
  const uint32_t stride = asset.weightStride();
  for (GLuint i = 0; i < kVectors; ++i) {
    attribute(kMasks + i, objects->masks, 4, GL_UNSIGNED_BYTE, kMaxLayers, 4 * i);
    if (4 * i < stride) {
      attribute(kWeights + i, posed.weights, static_cast<GLint>(std::min(stride - 4 * i, 4u)), GL_SHORT,
                static_cast<GLsizei>(stride * sizeof(int16_t)), 4 * i * sizeof(int16_t));
    } else {
      glDisableVertexAttribArray(kWeights + i);
      glVertexAttrib4f(kWeights + i, 0.0f, 0.0f, 0.0f, 0.0f);
    }
  }
}

void Renderer::State::takeMask(const RenderOptions& options) {
  objects->paint(options.mask ? options.layer : kAbsent,
                 options.mask ? options.mask_parts : std::span<const uint32_t>());
  if (options.mask == mask) return;
  mask = options.mask;
  if (mask) fillMask(mask_map, *mask);
}

void Renderer::State::bindValues(const FrameInput& input, const RenderOptions& options) {
  if (options.view == View::kBeauty && !asset.colors.empty()) {
    glBindBuffer(GL_ARRAY_BUFFER, objects->colors);
    glVertexAttribPointer(kValue, 4, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
    glEnableVertexAttribArray(kValue);
    return;
  }
  const std::vector<glm::vec4> shown = shownValues(asset, input, options);
  if (shown.empty()) {
    glDisableVertexAttribArray(kValue);
    glVertexAttrib4f(kValue, 1.0f, 1.0f, 1.0f, 1.0f);
    return;
  }
  refill(values, std::as_bytes(std::span(shown)));
  glBindBuffer(GL_ARRAY_BUFFER, values);
  glVertexAttribPointer(kValue, 4, GL_FLOAT, GL_FALSE, sizeof(glm::vec4), nullptr);
  glEnableVertexAttribArray(kValue);
}

void Renderer::State::fillScene(const RenderOptions& options, uint32_t weighed) {
  scene = sceneOf(options, exposure);
  for (uint32_t l = 0; l < asset.layerCount(); ++l)
    if (weighed >> l & 1u)
      scene.shown_layers[scene.layers / 4][static_cast<int>(scene.layers % 4)] = l, ++scene.layers;
  refill(scene_buffer, std::as_bytes(std::span(&scene, 1)));
  glBindBufferBase(GL_UNIFORM_BUFFER, kSceneSlot, scene_buffer);
}

void Renderer::State::bindMaterial(size_t part) const {
  glBindBufferRange(GL_UNIFORM_BUFFER, kMaterialSlot, objects->materials,
                    static_cast<GLintptr>(part * objects->material_stride), sizeof(gpu::Material));
}

void Renderer::State::drawShadow(const RenderOptions& options) {
  if (options.view != View::kBeauty) return;
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_frame);
  glViewport(0, 0, kShadowSize, kShadowSize);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_CLAMP);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5f, 2.0f);
  uint32_t drawn = 0;  // triangles
  const auto draw_to = [&](uint32_t end, bool holes) {
    glUseProgram(programs.shadow(holes));
    drawTriangles(drawn, end);
    drawn = end;
  };
  for (size_t p = 0; p < asset.parts.size(); ++p) {
    const Part& part = asset.parts[p];
    if (samplesSeen(part.base_color.w, 1) == 0) {
      draw_to(part.triangle_begin, false);
      drawn = part.triangle_end;
    }
    const uint32_t color = part.base_maps == kAbsent ? 0 : objects->base_maps[part.base_maps].color;
    if (drawn == part.triangle_end || color == 0 || asset.base_maps[part.base_maps].opaque_from == 0.0f)
      continue;
    draw_to(part.triangle_begin, false);
    bindTexture(kBaseColorMap, GL_TEXTURE_2D_ARRAY, color);
    bindMaterial(p);
    draw_to(part.triangle_end, true);
  }
  draw_to(asset.triangleCount(), false);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_DEPTH_CLAMP);
}

void Renderer::State::drawParts(const RenderOptions& options) {
  bindTexture(kShadowMap, GL_TEXTURE_2D, shadow_map);
  bindTexture(kPaintedMask, GL_TEXTURE_2D, mask_map);
  glEnable(GL_SAMPLE_MASK);
  GLint samples = 0;
  glGetIntegerv(GL_SAMPLES, &samples);
  for (size_t p = 0; p < asset.parts.size(); ++p) {
    const Part& part = asset.parts[p];
    AssetObjects::TextureSetNames set{};
    if (part.texture_set != kAbsent) set = objects->texture_sets[part.texture_set];
    AssetObjects::BaseMapNames own{};
    if (part.base_maps != kAbsent) own = objects->base_maps[part.base_maps];
    const auto bindMap = [&](GLint unit, uint32_t map) {
      bindTexture(unit, GL_TEXTURE_2D_ARRAY, map ? map : empty_map);
    };
    glUseProgram(
        programs.surface(options, set.normals != 0, own.color != 0, own.normal != 0, objects->painted(p)));
    bindMap(kBaseColorMap, own.color);
    bindMap(kBaseNormalMap, own.normal);
    bindMap(kNormalMaps, set.normals);
    bindMap(kShadingMaps, set.shading);
    bindMap(kMaskMaps, set.masks);
    bindMaterial(p);
    const uint32_t seen = samplesSeen(part.base_color.w, static_cast<uint32_t>(std::max(samples, 1)));
    if (seen == 0) continue;
    glSampleMaski(0, (1u << seen) - 1u);
    drawTriangles(part.triangle_begin, part.triangle_end);
  }
  glDisable(GL_SAMPLE_MASK);
  glActiveTexture(GL_TEXTURE0);
}

void Renderer::State::drawStrokes(const RenderOptions& options) {
  // Steps of the square root of two: a moving camera changes the choice of strokes seldom.
  const float wanted = scene.size.z / kStrokeLength;
  const float spacing = std::exp2(std::round(std::log2(wanted) * 2.0f) * 0.5f);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, stroke_indices);
  if (stroke_layer != options.layer || stroke_spacing != spacing) {
    const std::vector<uint32_t> chosen = strokeVertices(asset, options.layer, spacing);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(chosen.size() * sizeof(uint32_t)),
                 chosen.data(), GL_DYNAMIC_DRAW);
    strokes = static_cast<GLsizei>(chosen.size());
    stroke_layer = options.layer;
    stroke_spacing = spacing;
  }
  glUseProgram(programs.stroke);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  glDepthMask(GL_FALSE);
  glDrawElements(GL_POINTS, strokes, GL_UNSIGNED_INT, nullptr);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects->indices);
}

ContextLost::ContextLost(Tier on, const char* how)
    : Error(Exit::kEnvironment, std::string(gl::tierName(on)) + " tier", how, "draw again"),
      tier_(on),
      how_(how) {}

Renderer::Renderer(const AssetView& asset, gl::ResetStatus lost)
    : asset_(&asset), asked_(lost ? lost : gl::resetStatus()), state_(std::make_unique<State>()) {
  state_->show(asset);
}
Renderer::~Renderer() = default;

void Renderer::show(const AssetView& asset) {
  asset_ = &asset;
  check();
  if (!state_) return;
  std::unique_ptr<State> state = std::move(state_);
  state->show(asset);
  state_ = std::move(state);
}

// What the lost context held is given up.
void Renderer::lose(const char* how) {
  if (state_->generation == objectGeneration()) giveUpObjects();
  state_.reset();
  first_ = gl::nextTier(tier_);
  throw ContextLost(tier_, how);
}

void Renderer::check() {
  if (!state_) return;
  // Another renderer may have found it before.
  if (state_->generation != objectGeneration()) lose("the OpenGL context was lost");
  if (const Status status = gl::contextStatus(asked_, state_->objects->indices); !status.ok())
    lose(status.message);
}

uint32_t Renderer::draw(const FrameInput& input, const RenderOptions& options) try {
  checkPicture(*asset_, input, options);
  tier_ = std::max(options.tier, first_);
  check();
  if (!state_) {
    auto state = std::make_unique<State>();
    state->show(*asset_);
    state_ = std::move(state);
  }
  State& s = *state_;
  if (!s.target || s.target->width() != options.width || s.target->height() != options.height) {
    s.target.reset();
    s.target = std::make_unique<PictureTarget>(options.width, options.height);
  }
  if (options.times) options.times->clear();
  PosedBuffers posed{};
  if (const Status status = s.pose(input, options, tier_, asked_, posed); !status.ok()) lose(status.message);
  GpuTimes clock(options.times);
  s.takeMask(options);
  s.bindSurface(posed);
  s.bindValues(input, options);
  s.fillScene(options, posed.layers);

  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  s.drawShadow(options);

  s.target->bind();
  glEnable(GL_MULTISAMPLE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(s.programs.background);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  s.drawParts(options);
  if (options.view == View::kDirection) s.drawStrokes(options);
  const uint32_t texture = s.target->resolve();
  clock.end("draw");
  clock.read();
  glDisable(GL_FRAMEBUFFER_SRGB);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glBindVertexArray(0);
  glUseProgram(0);
  check();
  return texture;
} catch (const Error&) {
  check();  // which says it better
  throw;
}

pipeline::Image Renderer::render(const FrameInput& input, const RenderOptions& options) {
  draw(input, options);
  const size_t row = size_t{4} * options.width;
  std::vector<uint8_t> bytes(row * options.height);
  state_->target->readPixels(bytes.data());
  check();
  pipeline::Image image{options.width, options.height, 4, std::vector<float>(bytes.size())};
  for (uint32_t y = 0; y < options.height; ++y)
    std::transform(&bytes[row * (options.height - 1 - y)], &bytes[row * (options.height - 1 - y)] + row,
                   &image.pixels[row * y], [](uint8_t value) { return static_cast<float>(value) / 255.0f; });
  return image;
}

}  // namespace furrow::preview
