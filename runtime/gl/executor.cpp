#include "furrow/gl/executor.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "furrow/gl/tier.h"
#include "program.h"

namespace furrow::gl {

namespace {

constexpr size_t kBuffers = static_cast<size_t>(Buffer::kCount);
constexpr int kMostErrors = 64;  // a lost context never runs out of them

GLint limit(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

bool hasDebug() {
  return epoxy_gl_version() >= 43 || epoxy_has_gl_extension("GL_KHR_debug");
}

bool isTexels(Access access) {
  return access == Access::kFloats || access == Access::kWords;
}

}  // namespace

struct Executor::State {
  const FramePlan* plan = nullptr;
  std::array<GLuint, kBuffers> buffers{};
  std::vector<GLuint> programs;  // an item
  // Of the raster form.
  std::array<GLuint, kBuffers> texels{};  // buffer textures
  GLuint sums[2] = {}, framebuffer = 0, vertex_array = 0;
  GLint clip_distances = 0;  // that the context has
  bool debug = false;
  bool some = false;                 // kInstances is not all of them
  uint32_t active_layers = 0xffffu;  // of the last upload
  ResetStatus asked = nullptr;
  std::vector<std::byte> constants;  // an instance's kFrame or kMorphWeights
  bool lost = false;                 // the names are another context's by now, or nobody's

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (lost) return;
    std::sort(programs.begin(), programs.end());
    programs.erase(std::unique(programs.begin(), programs.end()), programs.end());
    for (GLuint program : programs) glDeleteProgram(program);
    glDeleteBuffers(static_cast<GLsizei>(kBuffers), buffers.data());
    if (plan->options().form != Form::kRaster) return;
    glDeleteTextures(static_cast<GLsizei>(kBuffers), texels.data());
    glDeleteTextures(2, sums);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteVertexArrays(1, &vertex_array);
  }

  bool raster() const { return plan->options().form == Form::kRaster; }
  std::span<std::byte> scratch(uint64_t bytes) { return std::span(constants).first(bytes); }
  // Of the raster form: what clears or fills a slice of layers that are all switched off is left out.
  bool isActive(const Item& item) const {
    if (item.kind == ItemKind::kBarrier || !item.captured.empty()) return true;
    const auto& layers = plan->slices()[item.slice].layers;
    return std::any_of(std::begin(layers), std::end(layers), [&](uint32_t layer) {
      return layer != kAbsent && (active_layers >> layer & 1u) != 0;
    });
  }
  GLuint buffer(Buffer id) const { return id == Buffer::kCount ? 0 : buffers[static_cast<size_t>(id)]; }
  Status checkContext();
  Status checkLimits(const Item& item) const;
  Status allocate(Buffer buffer);
  void makeTexels(const Binding& binding);
  GLuint programOf(const Item& item, Status& status) const;
  Status makeSums();
  void dispatch(const Item& item, uint32_t rows) const;
  void draw(const Item& item) const;
  void drawTo(uint32_t slice, uint32_t image) const;
  void setState() const;
  void readPointQ(std::span<std::byte> bytes) const;
};

Status Executor::State::checkContext() {
  const Status status = contextStatus(asked, buffer(Buffer::kFrame));
  lost = lost || !status.ok();
  return status;
}

Status Executor::State::checkLimits(const Item& item) const {
  if (item.kind != ItemKind::kDispatch) return {};
  const auto blocks = limit(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
  const auto storage = std::count_if(item.bindings.begin(), item.bindings.end(), [](const Binding& binding) {
    return binding.access == Access::kStorage;
  });
  if (storage > blocks)
    return Status::error(StatusCode::kUnavailable, "%s needs %d storage buffers and this OpenGL has %d",
                         item.label, static_cast<int>(storage), blocks);
  const auto slots = static_cast<uint32_t>(
      std::min(limit(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS), limit(GL_MAX_UNIFORM_BUFFER_BINDINGS)));
  for (const Binding& binding : item.bindings)
    if (binding.slot >= slots)
      return Status::error(StatusCode::kUnavailable, "%s binds slot %u and this OpenGL has %u", item.label,
                           binding.slot, slots);
  for (GLuint axis = 0; axis < 2; ++axis) {
    GLint most = 0;
    glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &most);
    if (item.groups[axis] > static_cast<uint32_t>(most))
      return Status::error(StatusCode::kUnavailable, "%s needs %u work-groups and this OpenGL allows %d",
                           item.label, item.groups[axis], most);
  }
  return {};
}

Status Executor::State::allocate(Buffer id) {
  const BufferDesc& desc = plan->buffer(id);
  if (desc.bytes == 0) return {};
  const bool uniform = id == Buffer::kFrame && plan->options().form != Form::kClustered;
  const auto most =
      uniform    ? static_cast<uint64_t>(limit(GL_MAX_UNIFORM_BLOCK_SIZE))
      : raster() ? uint64_t{sizeof(uint32_t)} * static_cast<uint64_t>(limit(GL_MAX_TEXTURE_BUFFER_SIZE))
                 : static_cast<uint64_t>(limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE));
  if (desc.bytes > most)
    return Status::error(StatusCode::kUnavailable, "buffer %s has %llu bytes and this OpenGL allows %llu",
                         desc.name, static_cast<unsigned long long>(desc.bytes),
                         static_cast<unsigned long long>(most));
  if (!desc.initial.empty() && desc.initial.size() != desc.bytes)
    return Status::error(StatusCode::kInvalidArgument, "buffer %s has %llu bytes and %zu to fill it",
                         desc.name, static_cast<unsigned long long>(desc.bytes), desc.initial.size());
  GLuint& name = buffers[static_cast<size_t>(id)];
  glGenBuffers(1, &name);
  glBindBuffer(GL_COPY_WRITE_BUFFER, name);
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(desc.bytes),
               desc.initial.empty() ? nullptr : desc.initial.data(),
               desc.lifetime == Lifetime::kPerAsset ? GL_STATIC_DRAW : GL_DYNAMIC_DRAW);
  if (glGetError() == GL_OUT_OF_MEMORY)
    return Status::error(StatusCode::kOutOfMemory, "no GPU memory for buffer %s of %llu bytes", desc.name,
                         static_cast<unsigned long long>(desc.bytes));
  if (debug) glObjectLabel(GL_BUFFER, name, -1, desc.name);
  return {};
}

void Executor::State::makeTexels(const Binding& binding) {
  const GLuint from = buffer(binding.buffer);
  if (!isTexels(binding.access) || from == 0) return;
  GLuint& texture = texels[static_cast<size_t>(binding.buffer)];
  if (texture) return;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_BUFFER, texture);
  glTexBuffer(GL_TEXTURE_BUFFER, binding.access == Access::kFloats ? GL_R32F : GL_R32UI, from);
  glBindTexture(GL_TEXTURE_BUFFER, 0);
}

// Laplacian steps have one program between them: what they bind to its slots differs, not the slots.
GLuint Executor::State::programOf(const Item& item, Status& status) const {
  for (size_t i = 0; i < programs.size(); ++i)
    if (const Item& other = plan->items()[i]; other.shader == item.shader && other.slice == item.slice)
      return programs[i];
  return makeProgram(item, status);
}

Status Executor::State::makeSums() {
  const SumsDesc& desc = plan->sums();
  glGenVertexArrays(1, &vertex_array);
  clip_distances = limit(GL_MAX_CLIP_DISTANCES);
  glGenFramebuffers(1, &framebuffer);
  const auto side = static_cast<uint32_t>(limit(GL_MAX_TEXTURE_SIZE));
  if (desc.width > side || desc.height > side)
    return Status::error(StatusCode::kUnavailable, "the sums are %u x %u and this OpenGL allows %u",
                         desc.width, desc.height, side);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);  // a host's would be read below
  glGenTextures(static_cast<GLsizei>(desc.images), sums);
  for (uint32_t image = 0; image < desc.images; ++image) {
    glBindTexture(GL_TEXTURE_2D_ARRAY, sums[image]);
    glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32F, static_cast<GLsizei>(desc.width),
                 static_cast<GLsizei>(desc.height), static_cast<GLsizei>(std::max(desc.slices, 1u)), 0,
                 GL_RGBA, GL_FLOAT, nullptr);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
    if (debug) glObjectLabel(GL_TEXTURE, sums[image], -1, "furrow sums");
  }
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  if (glGetError() == GL_OUT_OF_MEMORY)
    return Status::error(StatusCode::kOutOfMemory, "no GPU memory for %u x sums of %u x %u x %u", desc.images,
                         desc.width, desc.height, desc.slices);
  drawTo(0, 0);
  const GLenum complete = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (complete != GL_FRAMEBUFFER_COMPLETE)
    return Status::error(StatusCode::kUnavailable, "this OpenGL cannot draw into float textures");
  return {};
}

void Executor::State::drawTo(uint32_t slice, uint32_t image) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, sums[image], 0, static_cast<GLint>(slice));
}

// What captures and draws need, whatever the host left.
void Executor::State::setState() const {
  glBindVertexArray(vertex_array);
  drawTo(0, 0);  // without a window there is no other framebuffer, and captures want one too
  for (GLenum off : {GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_COLOR_LOGIC_OP,
                     GL_RASTERIZER_DISCARD, GL_PRIMITIVE_RESTART, GL_PROGRAM_POINT_SIZE})
    glDisable(off);
  for (int plane = 0; plane < clip_distances; ++plane)
    glDisable(GL_CLIP_DISTANCE0 + static_cast<GLenum>(plane));
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glPointSize(1.0f);
}

void Executor::State::dispatch(const Item& item, uint32_t rows) const {
  for (const Binding& binding : item.bindings)
    glBindBufferBase(binding.access == Access::kUniform ? GL_UNIFORM_BUFFER : GL_SHADER_STORAGE_BUFFER,
                     binding.slot, buffer(binding.buffer));
  glDispatchCompute(item.groups[0], rows, 1);
}

void Executor::State::draw(const Item& item) const {
  for (const Binding& binding : item.bindings) {
    if (binding.access == Access::kUniform) {
      glBindBufferBase(GL_UNIFORM_BUFFER, binding.slot, buffer(binding.buffer));
    } else if (binding.access == Access::kCapture) {
      glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, binding.slot, buffer(binding.buffer));
    } else if (binding.access == Access::kIndices) {
      glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer(binding.buffer));
    } else {
      glActiveTexture(GL_TEXTURE0 + binding.slot);
      if (isTexels(binding.access))
        glBindTexture(GL_TEXTURE_BUFFER, texels[static_cast<size_t>(binding.buffer)]);
      else
        glBindTexture(GL_TEXTURE_2D_ARRAY, sums[binding.access == Access::kOtherSums]);
    }
  }
  if (!item.captured.empty()) {
    glEnable(GL_RASTERIZER_DISCARD);
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(item.count));
    glEndTransformFeedback();
    glDisable(GL_RASTERIZER_DISCARD);
    for (const Binding& binding : item.bindings)
      if (binding.access == Access::kCapture) glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, binding.slot, 0);
    return;
  }
  drawTo(item.slice, item.image);
  glViewport(0, 0, static_cast<GLsizei>(plan->sums().width), static_cast<GLsizei>(plan->sums().height));
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(size_t{item.first} * sizeof(uint32_t)));
  glDisable(GL_BLEND);
}

// q = sum of q x angle over sum of angles, 1 where nothing was added.
void Executor::State::readPointQ(std::span<std::byte> bytes) const {
  const SumsDesc& desc = plan->sums();
  const size_t points = plan->asset().pointCount(), texels_a_slice = size_t{desc.width} * desc.height;
  std::vector<Float4> texels_read(texels_a_slice * desc.slices);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, sums[0]);
  glGetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA, GL_FLOAT, texels_read.data());
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  std::vector<float> q(points * plan->asset().layerCount(), 1.0f);
  for (size_t s = 0; s < plan->slices().size(); ++s)
    for (size_t p = 0; p < points; ++p) {
      const Float4& sum = texels_read[s * texels_a_slice + p];
      const float channels[3] = {sum.x, sum.y, sum.z};
      for (size_t c = 0; c < 3; ++c)
        if (const uint32_t layer = plan->slices()[s].layers[c]; layer != kAbsent && sum.w > 0.0f)
          q[layer * points + p] = channels[c] / sum.w;
    }
  std::memcpy(bytes.data(), q.data(), std::min(bytes.size(), q.size() * sizeof(float)));
}

Executor::Executor() = default;
Executor::~Executor() = default;

Status Executor::create(const FramePlan& plan, ResetStatus lost) {
  state_.reset();
  const Support support = querySupport();
  if (!(plan.options().form == Form::kRaster ? support.gpu_raster : support.gpu))
    return Status::error(StatusCode::kUnavailable, "%s", support.reason);

  auto state = std::make_unique<State>();
  state->plan = &plan;
  state->constants.resize(
      std::max(plan.instanceBytes(Buffer::kFrame), plan.instanceBytes(Buffer::kMorphWeights)));
  state->debug = hasDebug();
  state->asked = lost ? lost : resetStatus();
  for (int i = 0; i < kMostErrors && glGetError() != GL_NO_ERROR; ++i) {
  }
  for (size_t i = 0; i < kBuffers; ++i)
    if (const Status status = state->allocate(static_cast<Buffer>(i)); !status.ok()) return status;
  for (const Item& item : plan.items()) {
    if (const Status status = state->checkLimits(item); !status.ok()) return status;
    Status status;
    const bool has_shader = item.kind == ItemKind::kDispatch || item.kind == ItemKind::kDraw;
    state->programs.push_back(has_shader ? state->programOf(item, status) : 0);
    if (!status.ok()) return status;
    if (state->debug && has_shader) glObjectLabel(GL_PROGRAM, state->programs.back(), -1, item.label);
    for (const Binding& binding : item.bindings) state->makeTexels(binding);
  }
  if (state->raster())
    if (const Status status = state->makeSums(); !status.ok()) return status;
  state_ = std::move(state);
  return {};
}

Status Executor::upload(const FrameInput& input, uint32_t instance) {
  if (Status status = state_->checkContext(); !status.ok()) return status;
  const FramePlan& plan = *state_->plan;
  state_->active_layers = input.active_layers;
  std::span<std::byte> bytes = state_->scratch(plan.instanceBytes(Buffer::kFrame));
  plan.writeFrame(input, bytes);
  upload(Buffer::kFrame, bytes, instance * bytes.size());
  if (plan.options().posed_by_host) return {};
  bytes = state_->scratch(plan.instanceBytes(Buffer::kMorphWeights));
  plan.writeMorphWeights(input, bytes);
  upload(Buffer::kMorphWeights, bytes, instance * bytes.size());
  const bool linear = plan.options().skinning == Skinning::kLinear;
  upload(Buffer::kPalette, linear ? std::as_bytes(input.palette) : std::as_bytes(input.motions),
         instance * plan.instanceBytes(Buffer::kPalette));
  return {};
}

void Executor::giveUp() {
  if (state_) state_->lost = true;
}

void Executor::upload(Buffer buffer, std::span<const std::byte> bytes, uint64_t offset) {
  if (bytes.empty()) return;
  glBindBuffer(GL_COPY_WRITE_BUFFER, handle(buffer));
  glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes.size()),
                  bytes.data());
}

Status Executor::run(std::span<const uint32_t> instances, const Recorded& recorded) {
  State& s = *state_;
  if (Status status = s.checkContext(); !status.ok()) return status;
  const bool clustered = s.plan->options().form == Form::kClustered;
  if (clustered && (!instances.empty() || s.some)) {
    s.some = !instances.empty();
    upload(Buffer::kInstances,
           s.some ? std::as_bytes(instances) : s.plan->buffer(Buffer::kInstances).initial);
  }
  if (s.debug) glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, "furrow");
  if (s.raster()) s.setState();
  for (size_t i = 0; i < s.programs.size(); ++i) {
    const Item& item = s.plan->items()[i];
    if (s.raster() && !s.isActive(item)) continue;
    if (s.debug) glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, item.label);
    if (s.programs[i]) glUseProgram(s.programs[i]);
    constexpr GLfloat kNothing[4] = {};
    switch (item.kind) {
      case ItemKind::kDispatch:
        s.dispatch(item, s.some ? static_cast<uint32_t>(instances.size()) : item.groups[1]);
        break;
      case ItemKind::kDraw:
        s.draw(item);
        break;
      case ItemKind::kClear:
        s.drawTo(item.slice, item.image);
        glClearBufferfv(GL_COLOR, 0, kNothing);
        break;
      case ItemKind::kBarrier:  // OpenGL orders draws itself
        if (!s.raster()) glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        break;
    }
    if (s.debug) glPopDebugGroup();
    if (recorded) recorded(item);
  }
  if (s.raster()) {
    glActiveTexture(GL_TEXTURE0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glBindVertexArray(0);
  } else {
    // What comes next may draw from the results, read them back or write over the inputs.
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT);
  }
  glUseProgram(0);
  if (s.debug) glPopDebugGroup();
  return {};
}

void Executor::read(Buffer buffer, std::span<std::byte> bytes, uint64_t offset) const {
  if (bytes.empty()) return;
  if (buffer == Buffer::kPointQ && state_->raster()) return state_->readPointQ(bytes);
  glBindBuffer(GL_COPY_READ_BUFFER, handle(buffer));
  glGetBufferSubData(GL_COPY_READ_BUFFER, static_cast<GLintptr>(offset),
                     static_cast<GLsizeiptr>(bytes.size()), bytes.data());
}

uint32_t Executor::handle(Buffer buffer) const {
  return state_ ? state_->buffer(buffer) : 0;
}

}  // namespace furrow::gl
