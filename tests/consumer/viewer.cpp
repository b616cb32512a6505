// viewer ASSET MORPH [PREFIX]: a window with a face that one morph target moves, drawn by an engine's own
// renderer from an engine's own vertices. The key T goes to the next tier: gpu, gpu-raster, cpu. With PREFIX
// the keys are pressed by the program itself: it writes PREFIX_TIER.ppm for every tier, PREFIX_plain.ppm
// without wrinkles, says how far they are apart, and ends.

#include <epoxy/gl.h>
// epoxy first: it brings OpenGL's types.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "furrow/bind.h"
#include "furrow/drivers.h"
#include "furrow/gl/tiered_frame.h"

namespace {

using namespace furrow;

constexpr int kWidth = 512, kHeight = 640;

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "viewer: %s\n", what.c_str());
  std::exit(1);
}

void require(const Status& status) {
  if (!status.ok()) fail(status.message);
}

std::string readFile(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  if (!in) fail(name + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

// What this engine's importer made of the mesh: its own order, no vertex shared between triangles whose
// corners it met in different strips, UVs and the engine's own skinning (here: which vertex of the asset it
// follows).
struct EngineMesh {
  std::vector<Float3> positions;   // in the bind pose, the root's space
  std::vector<uint32_t> source;    // what the engine's skinning follows
  std::vector<uint32_t> weighted;  // what its weights are read from: found by binding
  std::vector<uint32_t> indices;
};

EngineMesh import(const AssetView& asset) {
  constexpr uint32_t kStrip = 50;  // triangles
  EngineMesh mesh;
  std::vector<uint32_t> own(asset.vertexCount(), kAbsent), part(asset.vertexCount());
  for (uint32_t p = 0; p < asset.parts.size(); ++p)
    std::fill(part.begin() + asset.parts[p].vertex_begin, part.begin() + asset.parts[p].vertex_end, p);
  for (const Part& each : asset.parts)
    for (uint32_t t = each.triangle_end; t-- > each.triangle_begin;) {
      if ((each.triangle_end - t) % kStrip == 1) std::fill(own.begin(), own.end(), kAbsent);
      for (uint32_t c = 0; c < 3; ++c) {
        const uint32_t v = asset.indices[3 * t + c];
        if (own[v] == kAbsent) {
          own[v] = static_cast<uint32_t>(mesh.source.size());
          mesh.source.push_back(v);
          mesh.positions.push_back(transformed(asset.parts[part[v]].rest, asset.positions[v]));
        }
        mesh.indices.push_back(own[v]);
      }
    }

  std::vector<uint32_t> points(mesh.positions.size());
  BindJob bind{&asset, mesh.positions, mesh.indices, {}, asset.position_error, {}, points};
  std::vector<uint32_t> scratch(bind.scratchSize());
  bind.scratch = scratch;
  require(bind.validate());
  const BindCounts counts = bind.run();
  std::printf("bound %u vertices of the engine to %u points, %u ambiguous, %u unmatched\n", counts.matched,
              asset.pointCount(), counts.ambiguous, counts.unmatched);
  for (uint32_t i = 0; i < points.size(); ++i)
    mesh.weighted.push_back(points[i] < asset.pointCount() ? asset.point_vertex[points[i]] : mesh.source[i]);
  return mesh;
}

const char* const kVertexShader = R"(
uniform samplerBuffer positions, normals, tangents, masks;
uniform isamplerBuffer weights;
uniform mat4 camera;
uniform int weight_stride, layers;
uniform bool wrinkled;
layout(location = 0) in uint source;
layout(location = 1) in uint weighted;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 vertex_color;
out vec3 normal;
out vec4 tangent;
out vec2 at_uv;
out vec4 tint;
out vec4 layer_weights[4];

vec3 three(samplerBuffer from, uint v) {
  return vec3(texelFetch(from, int(3u * v)).x, texelFetch(from, int(3u * v) + 1).x, texelFetch(from, int(3u * v) + 2).x);
}

void main() {
  normal = three(normals, source);
  tangent = texelFetch(tangents, int(source));
  at_uv = uv;
  tint = vertex_color;
  for (int i = 0; i < 4; ++i) layer_weights[i] = vec4(0.0);
  for (int l = 0; l < layers && wrinkled; ++l)
    layer_weights[l / 4][l % 4] = float(texelFetch(weights, int(weighted) * weight_stride + l).x) / 32767.0 *
                                  texelFetch(masks, int(source) * layers + l).x;
  gl_Position = camera * vec4(three(positions, source), 1.0);
}
)";

// Maps as furrow_shade.glsl asks for them; then the light of a lamp and the sky.
const char* const kFragmentHead = R"(
uniform sampler2DArray normal_maps, shading_maps, mask_maps;
uniform vec4 windows[32];
uniform uvec4 slices[16];
uniform bool has_maps;
uniform int layers;
uniform vec3 color;
in vec3 normal;
in vec4 tangent;
in vec2 at_uv;
in vec4 tint;
in vec4 layer_weights[4];
out vec4 pixel;
vec2 uv_dx, uv_dy;
#define FURROW_WINDOW(slice) windows[slice]
#define FURROW_NORMAL(at, slice, zoom) textureGrad(normal_maps, vec3(at, float(slice)), uv_dx * zoom, uv_dy * zoom).xy
#define FURROW_SHADING(at, slice, zoom) textureGrad(shading_maps, vec3(at, float(slice)), uv_dx * zoom, uv_dy * zoom).x
#define FURROW_MASK(uv, slice) textureGrad(mask_maps, vec3(uv, float(slice)), uv_dx, uv_dy)
#define FURROW_WEIGHT(layer) layer_weights[layer / 4u][layer % 4u]
#define FURROW_SLICES(layer) slices[layer]
)";
const char* const kFragmentBody = R"(
void main() {
  uv_dx = dFdx(at_uv);
  uv_dy = dFdy(at_uv);
  FurrowSurface wrinkles = furrowSurface(vec3(0.0, 0.0, 1.0), at_uv, has_maps ? uint(layers) : 0u);
  vec3 form = normalize(normal);
  vec3 n = normalize(mat3(tangent.xyz, tangent.w * cross(form, tangent.xyz), form) * wrinkles.normal);
  vec3 lamp = normalize(vec3(-0.6, 0.7, 0.5));
  float light = furrowFade(dot(form, lamp)) * max(dot(n, lamp), 0.0) * 0.8 + 0.15 + 0.05 * n.y;
  pixel = vec4(pow(color * tint.rgb * light * mix(1.0, wrinkles.cavity, 0.6), vec3(1.0 / 2.2)), 1.0);
}
)";

GLuint compile(GLenum type, std::initializer_list<const char*> text) {
  std::vector<const char*> pieces = {"#version 330 core\n"};
  pieces.insert(pieces.end(), text.begin(), text.end());
  const GLuint shader = glCreateShader(type);
  glShaderSource(shader, static_cast<GLsizei>(pieces.size()), pieces.data(), nullptr);
  glCompileShader(shader);
  GLint done = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  char log[1024] = {};
  if (!done) glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  if (!done) fail(log);
  return shader;
}

GLuint makeTexture(const Texture& texture) {
  if (texture.slices == 0) return 0;
  GLuint name;
  glGenTextures(1, &name);
  glBindTexture(GL_TEXTURE_2D_ARRAY, name);
  const std::byte* data = texture.data.data();
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const size_t bytes =
        textureLevelBytes(texture.format, texture.width, texture.height, level) * texture.slices;
    const auto w = static_cast<GLsizei>(std::max(texture.width >> level, 1u)),
               h = static_cast<GLsizei>(std::max(texture.height >> level, 1u)),
               slices = static_cast<GLsizei>(texture.slices);
    if (texture.format == TextureFormat::kRgba8)
      glTexImage3D(GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level), GL_RGBA8, w, h, slices, 0, GL_RGBA,
                   GL_UNSIGNED_BYTE, data);
    else
      glCompressedTexImage3D(
          GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level),
          texture.format == TextureFormat::kBc5 ? GL_COMPRESSED_RG_RGTC2 : GL_COMPRESSED_RED_RGTC1, w, h,
          slices, 0, static_cast<GLsizei>(bytes), data);
    data += bytes;
  }
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(texture.levels) - 1);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  return name;
}

template <typename T>
GLuint makeBuffer(GLenum target, const std::vector<T>& values) {
  GLuint name;
  glGenBuffers(1, &name);
  glBindBuffer(target, name);
  glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_STATIC_DRAW);
  return name;
}

class Viewer {
 public:
  Viewer(const AssetView& asset, const std::string& morph) : asset_(asset), mesh_(import(asset)) {
    morphs_.resize(asset.morphs.size());
    for (size_t m = 0; m < morphs_.size(); ++m)
      if (asset.morphs[m].name == morph) morphs_[m] = 1.0f;
    if (std::none_of(morphs_.begin(), morphs_.end(), [](float w) { return w != 0.0f; }))
      fail("the asset has no morph target " + morph);
    makeRenderer();
    regions_.resize(asset.layerCount());
    driveRegions(asset, morphs_, {}, regions_);
    // At rest every matrix of the palette takes its part to the root's space.
    palette_.resize(asset.palette.size());
    for (const Part& part : asset.parts)
      for (uint32_t i = part.vertex_begin * asset.influences; i < part.vertex_end * asset.influences; ++i)
        palette_[asset.joints[i]] = part.rest;
    std::string_view wanted;
    gl::TierChoice choice;
    require(gl::wantedTier("auto", wanted));
    require(gl::chooseTier(wanted, "", choice));
    std::printf("tier %s\n", choice.reason);
    start(choice.tier);
  }

  gl::Tier tier() const { return frame_->tier(); }
  void nextTier() { start(static_cast<gl::Tier>((static_cast<int>(tier()) + 1) % 3)); }
  void plain(bool plain) { plain_ = plain; }

  void draw() {
    FrameInput input;
    input.palette = palette_;
    input.morph_weights = morphs_;
    input.region_weights = regions_;
    if (const Status status = frame_->run(input); !status.ok()) {
      std::fprintf(stderr, "viewer: %s\n", status.message);  // the next frame has another tier
      return;
    }
    glViewport(0, 0, kWidth, kHeight);
    glEnable(GL_DEPTH_TEST);
    glClearColor(0.12f, 0.12f, 0.13f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUseProgram(program_);
    glBindVertexArray(vertices_);
    glUniform1i(uniform("wrinkled"), !plain_);
    bindResults();
    size_t first = 0;
    for (const Part& part : asset_.parts) {
      bindMaterial(part);
      const size_t count = 3 * size_t{part.triangle_end - part.triangle_begin};
      glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(first * sizeof(uint32_t)));
      first += count;
    }
  }

 private:
  enum Unit {
    kPositions,
    kNormals,
    kTangents,
    kWeights,
    kMasks,
    kNormalMaps,
    kShadingMaps,
    kMaskMaps,
    kUnits
  };

  void start(gl::Tier tier) {
    frame_ = std::make_unique<gl::TieredFrame>();
    require(frame_->create(asset_, tier));
  }

  GLint uniform(const char* name) const { return glGetUniformLocation(program_, name); }

  void makeRenderer() {
    const std::string shade = readFile(SHADE);
    program_ = glCreateProgram();
    glAttachShader(program_, compile(GL_VERTEX_SHADER, {kVertexShader}));
    glAttachShader(program_, compile(GL_FRAGMENT_SHADER, {kFragmentHead, shade.c_str(), kFragmentBody}));
    glLinkProgram(program_);
    glUseProgram(program_);
    const char* const names[kUnits] = {"positions", "normals",     "tangents",     "weights",
                                       "masks",     "normal_maps", "shading_maps", "mask_maps"};
    for (int i = 0; i < kUnits; ++i) glUniform1i(uniform(names[i]), i);
    glUniform1i(uniform("layers"), static_cast<GLint>(asset_.layerCount()));
    glUniform1i(uniform("weight_stride"), static_cast<GLint>(asset_.weightStride()));

    // From the front: what the morph target moves fills the middle of the window.
    std::vector<bool> moves(asset_.vertexCount());
    for (size_t m = 0; m < morphs_.size(); ++m)
      for (uint32_t v : asset_.morphs[m].vertices)
        if (morphs_[m] != 0.0f) moves[v] = true;
    Float3 low = {1e9f, 1e9f, 1e9f}, high = {-1e9f, -1e9f, -1e9f};
    float deepest = 1e9f;
    for (size_t i = 0; i < mesh_.positions.size(); ++i) {
      const Float3 p = mesh_.positions[i];
      deepest = std::min(deepest, p.z);
      if (!moves[mesh_.source[i]]) continue;
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    low.z = deepest - (high.z - deepest);
    high.z += high.z - deepest;
    const float scale = 1.2f / std::max((high.x - low.x) * kHeight / kWidth, high.y - low.y);
    const float across = scale * kHeight / kWidth, deep = 1.9f / (high.z - low.z);
    const float camera[16] = {across,
                              0,
                              0,
                              0,
                              0,
                              scale,
                              0,
                              0,
                              0,
                              0,
                              -deep,
                              0,
                              -across * 0.5f * (low.x + high.x),
                              -scale * 0.5f * (low.y + high.y),
                              deep * 0.5f * (low.z + high.z),
                              1};
    glUniformMatrix4fv(uniform("camera"), 1, GL_FALSE, camera);

    glGenVertexArrays(1, &vertices_);
    glBindVertexArray(vertices_);
    std::vector<Float2> uvs;
    for (uint32_t v : mesh_.source) uvs.push_back(asset_.uvs[v]);
    makeBuffer(GL_ARRAY_BUFFER, mesh_.source);
    glVertexAttribIPointer(0, 1, GL_UNSIGNED_INT, 0, nullptr);
    makeBuffer(GL_ARRAY_BUFFER, mesh_.weighted);
    glVertexAttribIPointer(1, 1, GL_UNSIGNED_INT, 0, nullptr);
    makeBuffer(GL_ARRAY_BUFFER, uvs);
    glVertexAttribPointer(2, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
    glVertexAttrib4f(3, 0.8f, 0.7f, 0.62f, 1.0f);
    if (!asset_.colors.empty()) {
      std::vector<uint8_t> colors;
      for (uint32_t v : mesh_.source)
        colors.insert(colors.end(), &asset_.colors[4 * v], &asset_.colors[4 * v] + 4);
      makeBuffer(GL_ARRAY_BUFFER, colors);
      glVertexAttribPointer(3, 4, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
      glEnableVertexAttribArray(3);
    }
    makeBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh_.indices);

    // A vertex's masks, for parts without a mask texture.
    std::vector<uint8_t> masks(size_t{asset_.vertexCount()} * asset_.layerCount(), 255);
    for (const Part& part : asset_.parts) {
      if (part.texture_set != kAbsent && asset_.texture_sets[part.texture_set].masks.slices > 0) continue;
      for (size_t l = 0; l < asset_.layerCount(); ++l)
        for (uint32_t v = part.vertex_begin; v < part.vertex_end && !asset_.layers[l].mask.empty(); ++v)
          masks[v * asset_.layerCount() + l] = asset_.layers[l].mask[v];
    }
    glGenTextures(kMasks + 1, texels_);
    glGenBuffers(kMasks, results_);
    masks_ = makeBuffer(GL_TEXTURE_BUFFER, masks);
    for (const TextureSet& set : asset_.texture_sets)
      for (const Texture* texture : {&set.normals, &set.shading, &set.masks})
        maps_.push_back(makeTexture(*texture));
  }

  void asTexels(Unit unit, GLenum format, GLuint buffer) const {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_BUFFER, texels_[unit]);
    glTexBuffer(GL_TEXTURE_BUFFER, format, buffer);
  }

  // What the frame computed, wherever it did: the same four buffer textures.
  void bindResults() const {
    GLuint buffers[4];
    if (const gl::Executor* gpu = frame_->executor()) {
      constexpr Buffer kResults[4] = {Buffer::kPositions, Buffer::kNormals, Buffer::kTangents,
                                      Buffer::kWeights};
      for (int i = 0; i < 4; ++i) buffers[i] = gpu->handle(kResults[i]);
    } else {
      const std::span<const std::byte> results[4] = {
          std::as_bytes(frame_->positions()), std::as_bytes(frame_->normals()),
          std::as_bytes(frame_->tangents()), std::as_bytes(frame_->weights())};
      for (int i = 0; i < 4; ++i) {
        glBindBuffer(GL_TEXTURE_BUFFER, buffers[i] = results_[i]);
        glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(results[i].size()), results[i].data(),
                     GL_STREAM_DRAW);
      }
    }
    asTexels(kPositions, GL_R32F, buffers[0]);
    asTexels(kNormals, GL_R32F, buffers[1]);
    asTexels(kTangents, GL_RGBA32F, buffers[2]);
    asTexels(kWeights, GL_R16I, buffers[3]);
    asTexels(kMasks, GL_R8, masks_);
  }

  void bindMaterial(const Part& part) const {
    const TextureSet* set = part.texture_set == kAbsent ? nullptr : &asset_.texture_sets[part.texture_set];
    const bool has_maps = set && set->normals.slices > 0;
    glUniform1i(uniform("has_maps"), has_maps);
    glUniform3f(uniform("color"), part.base_color.x, part.base_color.y, part.base_color.z);
    if (!has_maps) return;
    GLuint slices[kMaxLayers][4] = {};
    for (uint32_t l = 0; l < asset_.layerCount(); ++l) {
      slices[l][0] = set->compress_slice[l];
      slices[l][1] = set->stretch_slice[l];
      slices[l][2] = set->masks.slices > 0 ? asset_.layers[l].mask_slice : kAbsent;
    }
    glUniform4uiv(uniform("slices"), kMaxLayers, slices[0]);
    glUniform4fv(uniform("windows"), 2 * kMaxLayers, &set->windows[0].x);
    for (int i = 0; i < 3; ++i) {
      glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(kNormalMaps + i));
      glBindTexture(GL_TEXTURE_2D_ARRAY, maps_[3 * part.texture_set + static_cast<size_t>(i)]);
    }
  }

  const AssetView& asset_;
  EngineMesh mesh_;
  std::vector<float> morphs_, regions_;
  std::vector<Affine> palette_;
  std::unique_ptr<gl::TieredFrame> frame_;
  bool plain_ = false;
  GLuint program_ = 0, vertices_ = 0, masks_ = 0, texels_[kMasks + 1] = {}, results_[kMasks] = {};
  std::vector<GLuint> maps_;
};

void onKey(GLFWwindow* window, int key, int, int action, int) {
  auto* viewer = static_cast<Viewer*>(glfwGetWindowUserPointer(window));
  if (action != GLFW_PRESS) return;
  if (key == GLFW_KEY_T) viewer->nextTier();
  if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, GLFW_TRUE);
}

std::vector<uint8_t> picture(Viewer& viewer, const std::string& file) {
  viewer.draw();
  std::vector<uint8_t> pixels(size_t{3} * kWidth * kHeight);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, kWidth, kHeight, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  std::ofstream out(file, std::ios::binary);
  out << "P6\n" << kWidth << " " << kHeight << "\n255\n";
  for (size_t row = kHeight; row-- > 0;)
    out.write(reinterpret_cast<const char*>(&pixels[row * 3 * kWidth]), 3 * kWidth);
  return pixels;
}

void compare(const char* name, const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  int largest = 0;
  size_t changed = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(int{a[i]} - int{b[i]}));
    changed += std::abs(int{a[i]} - int{b[i]}) > 8;
  }
  std::printf("%s: at most %d of 255 from gpu, %zu values by more than 8\n", name, largest, changed);
}

void playScript(GLFWwindow* window, Viewer& viewer, const std::string& prefix) {
  const auto first = picture(viewer, prefix + "_" + gl::tierName(viewer.tier()) + ".ppm");
  for (int i = 0; i < 2; ++i) {
    onKey(window, GLFW_KEY_T, 0, GLFW_PRESS, 0);
    const char* name = gl::tierName(viewer.tier());
    compare(name, first, picture(viewer, prefix + "_" + name + ".ppm"));
    glfwSwapBuffers(window);
    glfwPollEvents();
  }
  viewer.plain(true);
  compare("plain", first, picture(viewer, prefix + "_plain.ppm"));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) fail("give an asset and a morph target");
  const std::string file = readFile(argv[1]);
  Asset asset;
  require(asset.load(std::as_bytes(std::span(file))));
  if (!glfwInit()) fail("no display");
  GLFWwindow* window = nullptr;
  for (const int version : {43, 33}) {
    if (window) break;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, version / 10);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, version % 10);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    window = glfwCreateWindow(kWidth, kHeight, "furrow in a window", nullptr, nullptr);
  }
  if (!window) fail("no OpenGL 3.3");
  glfwMakeContextCurrent(window);
  {
    Viewer viewer(asset.view(), argv[2]);
    glfwSetWindowUserPointer(window, &viewer);
    glfwSetKeyCallback(window, onKey);
    if (argc > 3) {
      playScript(window, viewer, argv[3]);
    } else {
      while (!glfwWindowShouldClose(window)) {
        viewer.draw();
        glfwSwapBuffers(window);
        glfwPollEvents();
      }
    }
  }
  glfwTerminate();
  return 0;
}
