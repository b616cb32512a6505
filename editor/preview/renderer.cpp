#include "editor/preview/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "editor/preview/cpu_frame.h"
#include "editor/preview/gl_objects.h"
#include "editor/preview/gpu_times.h"
#include "editor/preview/scene_setup.h"
#include "editor/preview/view_values.h"
#include "furrow/gl/executor.h"
#include "pipeline/error.h"
#include "preview_shaders.h"

namespace furrow::preview {

namespace {

using pipeline::Error;
using pipeline::Exit;

// Attribute slots of surface_vertex.glsl.
constexpr GLuint kPosition = 0, kNormal = 1, kTangent = 2, kUv = 3, kWeights = 4, kMasks = 8, kValue = 12;
constexpr GLuint kVectors = kMaxLayers / 4;  // weights and masks go in fours

// Texture units.
constexpr GLint kNormalMaps = 0, kShadingMaps = 1, kMaskMaps = 2, kShadowMap = 3, kBaseColorMap = 4,
                kBaseNormalMap = 5;

constexpr float kAnisotropy = 4.0f;

static_assert(gpu::kMaxPreviewLayers == kMaxLayers);
static_assert(gpu::kShadingNone == static_cast<uint32_t>(Shading::kNone) &&
              gpu::kViewMorph == static_cast<uint32_t>(View::kMorph));

template <typename T>
GlObject makeBuffer(GLenum target, std::span<const T> values, GLenum usage) {
  GlObject buffer(GlKind::kBuffer);
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(values.size_bytes()), values.data(), usage);
  return buffer;
}

template <typename T>
void refill(uint32_t buffer, GLenum target, std::span<const T> values) {
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(values.size_bytes()), values.data(), GL_STREAM_DRAW);
}

// Null if the texture has no slices: sampling it is then excluded by the material.
GlObject makeTexture(const Texture& texture) {
  if (texture.slices == 0) return {};
  constexpr GLenum kFormats[] = {GL_COMPRESSED_RG_RGTC2, GL_COMPRESSED_RED_RGTC1, GL_RGBA8,
                                 GL_COMPRESSED_SRGB_S3TC_DXT1_EXT, GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT};
  const GLenum format = kFormats[static_cast<size_t>(texture.format)];
  GlObject object(GlKind::kTexture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, object);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  size_t offset = 0;
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const size_t bytes =
        textureLevelBytes(texture.format, texture.width, texture.height, level) * texture.slices;
    const auto width = static_cast<GLsizei>(std::max(texture.width >> level, 1u));
    const auto height = static_cast<GLsizei>(std::max(texture.height >> level, 1u));
    const auto slices = static_cast<GLsizei>(texture.slices);
    const std::byte* data = texture.data.subspan(offset, bytes).data();
    if (texture.format == TextureFormat::kRgba8)
      glTexImage3D(GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level), GL_RGBA8, width, height, slices, 0,
                   GL_RGBA, GL_UNSIGNED_BYTE, data);
    else
      glCompressedTexImage3D(GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level), format, width, height, slices, 0,
                             static_cast<GLsizei>(bytes), data);
    offset += bytes;
  }
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(texture.levels) - 1);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_REPEAT);
  // It more than doubles the time of a picture there.
  if (epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic") && !isSoftwareGl())
    glTexParameterf(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_ANISOTROPY_EXT, kAnisotropy);
  return object;
}

struct TextureSetObjects {
  GlObject normals, shading, masks;
};
struct BaseMapObjects {
  GlObject color, normal;
};

// Where the vertex shader reads a posed surface.
struct PosedBuffers {
  uint32_t positions, normals, tangents, weights;
};

// The cpu tier's frame in buffers.
class UploadedFrame {
 public:
  explicit UploadedFrame(const AssetView& asset) : frame_(asset) {
    for (GlObject& buffer : buffers_) buffer = GlObject(GlKind::kBuffer);
  }

  // `mask`: a value a vertex that the weights of `layer` are multiplied by, or empty.
  PosedBuffers run(const FrameInput& input, uint32_t layer, std::span<const float> mask, StageTimes* times) {
    frame_.run(input, times);
    StageClock clock(times);
    for (size_t v = 0; v < mask.size(); ++v) {
      int16_t& weight = frame_.weights[v * (frame_.weights.size() / mask.size()) + layer];
      weight = static_cast<int16_t>(std::lround(mask[v] * static_cast<float>(weight)));
    }
    refill(buffers_[0], GL_ARRAY_BUFFER, std::span<const Float3>(frame_.positions));
    refill(buffers_[1], GL_ARRAY_BUFFER, std::span<const Float3>(frame_.normals));
    refill(buffers_[2], GL_ARRAY_BUFFER, std::span<const Float4>(frame_.tangents));
    refill(buffers_[3], GL_ARRAY_BUFFER, std::span<const int16_t>(frame_.weights));
    clock.end("upload");
    return {buffers_[0], buffers_[1], buffers_[2], buffers_[3]};
  }

 private:
  CpuFrame frame_;
  std::array<GlObject, 4> buffers_;
};

class GpuFrame {
 public:
  GpuFrame(const AssetView& asset, Tier tier, gl::ResetStatus lost)
      : plan_(asset, {.form = gl::formOf(tier)}), generation_(objectGeneration()) {
    if (const Status status = executor_.create(plan_, lost); !status.ok())
      throw Error(status.code == StatusCode::kOutOfMemory || status.code == StatusCode::kUnavailable
                      ? Exit::kEnvironment
                      : Exit::kBadData,
                  std::string(gl::tierName(tier)) + " tier", status.message, "use the cpu tier");
  }

  ~GpuFrame() {
    if (generation_ != objectGeneration()) executor_.giveUp();
  }
  GpuFrame(const GpuFrame&) = delete;
  GpuFrame& operator=(const GpuFrame&) = delete;

  // Fails where the context was lost.
  Status run(const FrameInput& input, StageTimes* times, PosedBuffers& out) {
    GpuTimes clock(times);
    Status status = executor_.upload(input);
    clock.end("upload");
    if (status.ok())
      status = executor_.run({}, [&](const Item& item) {
        constexpr std::string_view kPrefix = "furrow ";
        std::string_view name = item.label;
        if (name.starts_with(kPrefix)) name.remove_prefix(kPrefix.size());
        clock.end(name);
      });
    if (!status.ok()) return status;
    clock.read();
    out = {executor_.handle(Buffer::kPositions), executor_.handle(Buffer::kNormals),
           executor_.handle(Buffer::kTangents), executor_.handle(Buffer::kWeights)};
    return {};
  }

 private:
  FramePlan plan_;
  gl::Executor executor_;
  uint32_t generation_;
};

}  // namespace

struct Renderer::State {
  explicit State(const AssetView& asset);

  Status pose(const FrameInput& input, const RenderOptions& options, Tier tier, gl::ResetStatus lost,
              PosedBuffers& out);
  void bindSurface(const PosedBuffers& posed) const;
  void bindValues(const FrameInput& input, const RenderOptions& options);
  void fillScene(const RenderOptions& options);
  uint32_t surfaceProgram(const RenderOptions& options, bool maps, bool base_color, bool base_normal);
  void drawShadow(const RenderOptions& options);
  void drawParts(const RenderOptions& options);
  void drawStrokes(const RenderOptions& options);

  const uint32_t generation = objectGeneration();
  std::vector<Layer> layers;  // of `asset`
  AssetView asset;
  uint32_t unmasked = kAbsent;  // the layer whose mask is painted: its weights are masked already
  std::map<std::tuple<View, Shading, Lighting, bool, bool, bool>, GlObject>
      surface;  // programs by surfaceProgram()'s constants
  GlObject shadow, background, stroke;
  GlObject vertex_array, uvs, colors, masks, indices, values, stroke_indices, scene_buffer, material_buffer;
  GlObject shadow_map, shadow_frame, empty_map;
  std::vector<TextureSetObjects> texture_sets;
  std::vector<BaseMapObjects> base_maps;
  GLintptr material_stride = 0;
  gpu::Scene scene{};
  float stroke_spacing = 0.0f;
  uint32_t stroke_layer = kAbsent;
  GLsizei strokes = 0;
  std::unique_ptr<UploadedFrame> cpu;
  std::unique_ptr<GpuFrame> gpu_frame, raster_frame;
  std::unique_ptr<PictureTarget> target;

 private:
  PosedBuffers poseOnCpu(const FrameInput& input, const RenderOptions& options);
  void unmask(uint32_t layer);
  void makePrograms();
  void makeShadowMap();
  void makeMaterials();
  void makeMasks();
};

Renderer::State::State(const AssetView& view) : layers(view.layers.begin(), view.layers.end()), asset(view) {
  asset.layers = layers;
  makePrograms();
  makeShadowMap();
  for (const TextureSet& set : asset.texture_sets)
    texture_sets.push_back({makeTexture(set.normals), makeTexture(set.shading), makeTexture(set.masks)});
  for (const BaseMaps& maps : asset.base_maps)
    base_maps.push_back({makeTexture(maps.color), makeTexture(maps.normal)});
  vertex_array = GlObject(GlKind::kVertexArray);
  glBindVertexArray(vertex_array);
  indices = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, asset.indices, GL_STATIC_DRAW);
  uvs = makeBuffer(GL_ARRAY_BUFFER, asset.uvs, GL_STATIC_DRAW);
  colors = makeBuffer(GL_ARRAY_BUFFER, asset.colors, GL_STATIC_DRAW);
  values = GlObject(GlKind::kBuffer);
  stroke_indices = GlObject(GlKind::kBuffer);
  scene_buffer = GlObject(GlKind::kBuffer);
  makeMasks();
  makeMaterials();
  // A sampler must have a complete texture even where nothing is read from it.
  const std::array<std::byte, 4> texel{};
  empty_map = makeTexture({TextureFormat::kRgba8, 1, 1, 1, 1, texel});
}

void Renderer::State::makePrograms() {
  shadow = makeProgram("shadow", {shaders::kShadowVertex}, {}, {shaders::kShadowFragment});
  background = makeProgram("background", {shaders::kBackgroundVertex}, {},
                           {shaders::kFurrowShade, shaders::kLighting, shaders::kBackgroundFragment});
  stroke =
      makeProgram("stroke", {shaders::kStrokeVertex}, {shaders::kStrokeGeometry}, {shaders::kStrokeFragment});
}

uint32_t Renderer::State::surfaceProgram(const RenderOptions& options, bool maps, bool base_color,
                                         bool base_normal) {
  // Only the beauty view knows shadings.
  const Shading shading = options.view == View::kBeauty ? options.shading : Shading::kNone;
  GlObject& program = surface[{options.view, shading, options.lighting, maps, base_color, base_normal}];
  if (program) return program;
  const auto truth = [](bool value) { return value ? "true" : "false"; };
  const std::string constants =
      "const uint kView = " + std::to_string(static_cast<uint32_t>(options.view)) +
      "u;\nconst uint kShading = " + std::to_string(static_cast<uint32_t>(shading)) +
      "u;\nconst bool kBlinn = " + truth(options.lighting == Lighting::kBlinn) +
      ";\nconst bool kMaps = " + truth(maps) + ";\nconst bool kBaseColor = " + truth(base_color) +
      ";\nconst bool kBaseNormal = " + truth(base_normal) + ";\n";
  program = makeProgram("surface", {constants.c_str(), shaders::kSurfaceVertex}, {},
                        {constants.c_str(), shaders::kSurfaceMaps, shaders::kFurrowShade, shaders::kLighting,
                         shaders::kSurfaceFragment});
  glUseProgram(program);
  glUniform1i(glGetUniformLocation(program, "normal_maps"), kNormalMaps);
  glUniform1i(glGetUniformLocation(program, "shading_maps"), kShadingMaps);
  glUniform1i(glGetUniformLocation(program, "mask_maps"), kMaskMaps);
  glUniform1i(glGetUniformLocation(program, "shadow_map"), kShadowMap);
  glUniform1i(glGetUniformLocation(program, "base_color_map"), kBaseColorMap);
  glUniform1i(glGetUniformLocation(program, "base_normal_map"), kBaseNormalMap);
  return program;
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

void Renderer::State::makeMaterials() {
  GLint alignment = 1;
  glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
  material_stride = (static_cast<GLintptr>(sizeof(gpu::Material)) + alignment - 1) / alignment * alignment;
  std::vector<std::byte> bytes(static_cast<size_t>(material_stride) * asset.parts.size());
  for (size_t p = 0; p < asset.parts.size(); ++p) {
    const Part& part = asset.parts[p];
    gpu::Material material{};
    material.base_color = shownColor(asset, part);
    material.roughness = part.roughness;
    if (part.base_maps != kAbsent) {
      const BaseMaps& maps = asset.base_maps[part.base_maps];
      const float *color = maps.color_uv, *normal = maps.normal_uv;
      material.color_uv = {color[0], color[1], color[2], color[3]};
      material.normal_uv = {normal[0], normal[1], normal[2], normal[3]};
      material.color_at_normal_at = {color[4], color[5], normal[4], normal[5]};
      material.opaque_from = maps.opaque_from;
    }
    for (glm::uvec4& slices : material.slices) slices = glm::uvec4(kAbsent);
    if (part.texture_set != kAbsent) {
      const TextureSet& set = asset.texture_sets[part.texture_set];
      material.with_masks = set.masks.slices > 0;
      static_assert(sizeof set.windows == sizeof material.windows);
      std::memcpy(material.windows, set.windows, sizeof material.windows);
      for (uint32_t l = 0; l < asset.layerCount(); ++l)
        material.slices[l] = {set.compress_slice[l], set.stretch_slice[l],
                              material.with_masks && l != unmasked ? asset.layers[l].mask_slice : kAbsent, 0};
    }
    std::memcpy(&bytes[p * static_cast<size_t>(material_stride)], &material, sizeof material);
  }
  material_buffer = makeBuffer(GL_UNIFORM_BUFFER, std::span<const std::byte>(bytes), GL_STATIC_DRAW);
}

void Renderer::State::makeMasks() {
  std::vector<uint8_t> bytes(size_t{asset.vertexCount()} * kMaxLayers, 255);
  for (size_t l = 0; l < asset.layers.size(); ++l)
    for (size_t v = 0; v < asset.layers[l].mask.size() && l != unmasked; ++v)
      bytes[v * kMaxLayers + l] = asset.layers[l].mask[v];
  masks = makeBuffer(GL_ARRAY_BUFFER, std::span<const uint8_t>(bytes), GL_STATIC_DRAW);
}

void Renderer::State::unmask(uint32_t layer) {
  if (layer == unmasked) return;
  unmasked = layer;
  makeMasks();
  makeMaterials();
}

PosedBuffers Renderer::State::poseOnCpu(const FrameInput& input, const RenderOptions& options) {
  if (!cpu) cpu = std::make_unique<UploadedFrame>(asset);
  const std::span<const float> mask = unmasked == kAbsent ? std::span<const float>() : options.mask;
  if (options.bias.empty()) return cpu->run(input, options.layer, mask, options.times);
  std::vector<int16_t> painted;
  for (const float value : options.bias)
    painted.push_back(static_cast<int16_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 32767.0f)));
  std::span<const int16_t>& bias = layers[options.layer].bias;
  const std::span<const int16_t> own = std::exchange(bias, painted);
  const PosedBuffers posed = cpu->run(input, options.layer, mask, options.times);
  bias = own;
  return posed;
}

Status Renderer::State::pose(const FrameInput& input, const RenderOptions& options, Tier tier,
                             gl::ResetStatus lost, PosedBuffers& out) {
  const bool masked = tier == Tier::kCpu && options.view == View::kBeauty && !options.mask.empty();
  unmask(masked ? options.layer : kAbsent);
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
  attribute(kUv, uvs, 2, GL_FLOAT, sizeof(Float2), 0);
  const uint32_t stride = asset.weightStride();
  for (GLuint i = 0; i < kVectors; ++i) {
    attribute(kMasks + i, masks, 4, GL_UNSIGNED_BYTE, kMaxLayers, 4 * i);
    if (4 * i < stride) {
      attribute(kWeights + i, posed.weights, static_cast<GLint>(std::min(stride - 4 * i, 4u)), GL_SHORT,
                static_cast<GLsizei>(stride * sizeof(int16_t)), 4 * i * sizeof(int16_t));
    } else {
      glDisableVertexAttribArray(kWeights + i);
      glVertexAttrib4f(kWeights + i, 0.0f, 0.0f, 0.0f, 0.0f);
    }
  }
}

void Renderer::State::bindValues(const FrameInput& input, const RenderOptions& options) {
  if (options.view == View::kBeauty && !asset.colors.empty()) {
    glBindBuffer(GL_ARRAY_BUFFER, colors);
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
  refill(values, GL_ARRAY_BUFFER, std::span<const glm::vec4>(shown));
  glVertexAttribPointer(kValue, 4, GL_FLOAT, GL_FALSE, sizeof(glm::vec4), nullptr);
  glEnableVertexAttribArray(kValue);
}

void Renderer::State::fillScene(const RenderOptions& options) {
  scene = sceneOf(asset, options);
  refill(scene_buffer, GL_UNIFORM_BUFFER, std::span<const gpu::Scene>(&scene, 1));
  glBindBufferBase(GL_UNIFORM_BUFFER, kSceneSlot, scene_buffer);
}

void Renderer::State::drawShadow(const RenderOptions& options) {
  if (options.view != View::kBeauty) return;
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_frame);
  glViewport(0, 0, kShadowSize, kShadowSize);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(shadow);
  glEnable(GL_DEPTH_CLAMP);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5f, 2.0f);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(asset.indices.size()), GL_UNSIGNED_INT, nullptr);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_DEPTH_CLAMP);
}

void Renderer::State::drawParts(const RenderOptions& options) {
  const auto bind = [](GLint unit, GLenum kind, uint32_t texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(kind, texture);
  };
  bind(kShadowMap, GL_TEXTURE_2D, shadow_map);
  for (size_t p = 0; p < asset.parts.size(); ++p) {
    const Part& part = asset.parts[p];
    const TextureSetObjects* set = part.texture_set == kAbsent ? nullptr : &texture_sets[part.texture_set];
    const auto mapOr = [&](const GlObject TextureSetObjects::*map) -> uint32_t {
      return set && set->*map ? set->*map : empty_map;
    };
    const BaseMapObjects* base = part.base_maps == kAbsent ? nullptr : &base_maps[part.base_maps];
    const uint32_t color = base ? base->color : 0, normal = base ? base->normal : 0;
    glUseProgram(surfaceProgram(options, set && set->normals, color != 0, normal != 0));
    bind(kBaseColorMap, GL_TEXTURE_2D_ARRAY, color ? color : empty_map);
    bind(kBaseNormalMap, GL_TEXTURE_2D_ARRAY, normal ? normal : empty_map);
    bind(kNormalMaps, GL_TEXTURE_2D_ARRAY, mapOr(&TextureSetObjects::normals));
    bind(kShadingMaps, GL_TEXTURE_2D_ARRAY, mapOr(&TextureSetObjects::shading));
    bind(kMaskMaps, GL_TEXTURE_2D_ARRAY, mapOr(&TextureSetObjects::masks));
    glBindBufferRange(GL_UNIFORM_BUFFER, kMaterialSlot, material_buffer,
                      static_cast<GLintptr>(p) * material_stride, sizeof(gpu::Material));
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * (part.triangle_end - part.triangle_begin)),
                   GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(size_t{part.triangle_begin} * 3 * sizeof(uint32_t)));
  }
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
  glUseProgram(stroke);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  glDepthMask(GL_FALSE);
  glDrawElements(GL_POINTS, strokes, GL_UNSIGNED_INT, nullptr);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
}

ContextLost::ContextLost(Tier on, const char* how)
    : Error(Exit::kEnvironment, std::string(gl::tierName(on)) + " tier", how, "draw again"),
      tier_(on),
      how_(how) {}

Renderer::Renderer(const AssetView& asset, gl::ResetStatus lost)
    : asset_(asset), asked_(lost ? lost : gl::resetStatus()), state_(std::make_unique<State>(asset)) {}
Renderer::~Renderer() = default;

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
  if (const Status status = gl::contextStatus(asked_, state_->indices); !status.ok()) lose(status.message);
}

uint32_t Renderer::draw(const FrameInput& input, const RenderOptions& options) try {
  checkPicture(asset_, input, options);
  tier_ = std::max(options.tier, first_);
  check();
  if (!state_) state_ = std::make_unique<State>(asset_);
  State& s = *state_;
  if (!s.target || s.target->width() != options.width || s.target->height() != options.height) {
    s.target.reset();
    s.target = std::make_unique<PictureTarget>(options.width, options.height);
  }
  if (options.times) options.times->clear();
  PosedBuffers posed{};
  if (const Status status = s.pose(input, options, tier_, asked_, posed); !status.ok()) lose(status.message);
  GpuTimes clock(options.times);
  s.bindSurface(posed);
  s.bindValues(input, options);
  s.fillScene(options);

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
  glUseProgram(s.background);
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
