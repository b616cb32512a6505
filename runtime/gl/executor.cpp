#include "furrow/gl/executor.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <string>

namespace furrow::gl {

namespace {

constexpr size_t kBuffers = static_cast<size_t>(Buffer::kCount);
constexpr size_t kShaders = static_cast<size_t>(Shader::kCount);

GLint limit(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

bool hasDebug() {
  return epoxy_gl_version() >= 43 || epoxy_has_gl_extension("GL_KHR_debug");
}

// The first line of a compile or link log that says something.
template <typename GetLength, typename GetLog>
std::string firstLine(GLuint name, GetLength get_length, GetLog get_log) {
  GLint length = 0;
  get_length(name, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
  get_log(name, length, nullptr, log.data());
  const size_t begin = log.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || log[begin] == '\0') return "the driver gave no reason";
  return log.substr(begin, log.find_first_of(std::string("\r\n\0", 3), begin) - begin);
}

const char* shaderName(Shader shader) {
  static constexpr const char* kNames[kShaders] = {"deform", "compress", "smooth", "respond"};
  return kNames[static_cast<size_t>(shader)];
}

}  // namespace

Support querySupport() {
  Support support;
  const int version = epoxy_gl_version();
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const char* name = renderer ? renderer : "unknown renderer";
  support.gpu = epoxy_is_desktop_gl() && version >= 43;
  std::snprintf(support.reason, sizeof support.reason, "%s, OpenGL%s %d.%d%s", name,
                epoxy_is_desktop_gl() ? "" : " ES", version / 10, version % 10,
                support.gpu ? "" : "; compute needs OpenGL 4.3");
  return support;
}

struct Executor::State {
  const FramePlan* plan = nullptr;
  std::array<GLuint, kBuffers> buffers{};
  std::array<GLuint, kShaders> programs{};
  bool debug = false;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    for (GLuint program : programs) glDeleteProgram(program);
    glDeleteBuffers(static_cast<GLsizei>(kBuffers), buffers.data());
  }

  Status checkLimits() const;
  Status compile(Shader shader);
  Status allocate(Buffer buffer);
};

Status Executor::State::checkLimits() const {
  const auto blocks = limit(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
  const auto slots =
      std::min(limit(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS), limit(GL_MAX_UNIFORM_BUFFER_BINDINGS));
  GLint groups[2];
  for (GLuint axis = 0; axis < 2; ++axis)
    glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &groups[axis]);
  for (const Dispatch& dispatch : plan->dispatches()) {
    const auto storage =
        std::count_if(dispatch.bindings.begin(), dispatch.bindings.end(),
                      [](const Binding& binding) { return binding.buffer != Buffer::kFrame; });
    if (storage > blocks)
      return Status::error(StatusCode::kUnavailable, "%s needs %d storage buffers and this OpenGL has %d",
                           dispatch.label, static_cast<int>(storage), blocks);
    for (const Binding& binding : dispatch.bindings)
      if (binding.slot >= static_cast<uint32_t>(slots))
        return Status::error(StatusCode::kUnavailable, "%s binds slot %u and this OpenGL has %d",
                             dispatch.label, binding.slot, slots);
    for (int axis = 0; axis < 2; ++axis)
      if (dispatch.groups[axis] > static_cast<uint32_t>(groups[axis]))
        return Status::error(StatusCode::kUnavailable, "%s needs %u work-groups and this OpenGL allows %d",
                             dispatch.label, dispatch.groups[axis], groups[axis]);
  }
  return {};
}

Status Executor::State::compile(Shader shader) {
  GLuint& program = programs[static_cast<size_t>(shader)];
  if (program) return {};
  const GLuint stage = glCreateShader(GL_COMPUTE_SHADER);
  const char* source = shaderSource(shader);
  glShaderSource(stage, 1, &source, nullptr);
  glCompileShader(stage);
  GLint done = GL_FALSE;
  glGetShaderiv(stage, GL_COMPILE_STATUS, &done);
  if (!done) {
    const std::string line = firstLine(stage, glGetShaderiv, glGetShaderInfoLog);
    glDeleteShader(stage);
    return Status::error(StatusCode::kUnavailable, "shader %s: %s", shaderName(shader), line.c_str());
  }
  program = glCreateProgram();
  glAttachShader(program, stage);
  glLinkProgram(program);
  glDetachShader(program, stage);
  glDeleteShader(stage);
  glGetProgramiv(program, GL_LINK_STATUS, &done);
  if (!done)
    return Status::error(StatusCode::kUnavailable, "shader %s: %s", shaderName(shader),
                         firstLine(program, glGetProgramiv, glGetProgramInfoLog).c_str());
  if (debug) glObjectLabel(GL_PROGRAM, program, -1, shaderName(shader));
  return {};
}

Status Executor::State::allocate(Buffer buffer) {
  const BufferDesc& desc = plan->buffer(buffer);
  if (desc.bytes == 0) return {};
  const auto most = static_cast<uint64_t>(
      limit(buffer == Buffer::kFrame ? GL_MAX_UNIFORM_BLOCK_SIZE : GL_MAX_SHADER_STORAGE_BLOCK_SIZE));
  if (desc.bytes > most)
    return Status::error(StatusCode::kUnavailable, "buffer %s has %llu bytes and this OpenGL allows %llu",
                         desc.name, static_cast<unsigned long long>(desc.bytes),
                         static_cast<unsigned long long>(most));
  if (!desc.initial.empty() && desc.initial.size() != desc.bytes)
    return Status::error(StatusCode::kInvalidArgument, "buffer %s has %llu bytes and %zu to fill it",
                         desc.name, static_cast<unsigned long long>(desc.bytes), desc.initial.size());
  GLuint& name = buffers[static_cast<size_t>(buffer)];
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

Executor::Executor() = default;
Executor::~Executor() = default;

Status Executor::create(const FramePlan& plan) {
  state_.reset();
  const Support support = querySupport();
  if (!support.gpu) return Status::error(StatusCode::kUnavailable, "%s", support.reason);

  auto state = std::make_unique<State>();
  state->plan = &plan;
  state->debug = hasDebug();
  while (glGetError() != GL_NO_ERROR) {
  }
  if (const Status status = state->checkLimits(); !status.ok()) return status;
  for (const Dispatch& dispatch : plan.dispatches())
    if (const Status status = state->compile(dispatch.shader); !status.ok()) return status;
  for (size_t i = 0; i < kBuffers; ++i)
    if (const Status status = state->allocate(static_cast<Buffer>(i)); !status.ok()) return status;
  state_ = std::move(state);
  return {};
}

void Executor::upload(Buffer buffer, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  glBindBuffer(GL_COPY_WRITE_BUFFER, handle(buffer));
  glBufferSubData(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(bytes.size()), bytes.data());
}

void Executor::run() {
  if (state_->debug) glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, "furrow");
  for (const Dispatch& dispatch : state_->plan->dispatches()) {
    if (state_->debug) glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, dispatch.label);
    glUseProgram(state_->programs[static_cast<size_t>(dispatch.shader)]);
    for (const Binding& binding : dispatch.bindings)
      glBindBufferBase(binding.buffer == Buffer::kFrame ? GL_UNIFORM_BUFFER : GL_SHADER_STORAGE_BUFFER,
                       binding.slot, handle(binding.buffer));
    glDispatchCompute(dispatch.groups[0], dispatch.groups[1], 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    if (state_->debug) glPopDebugGroup();
  }
  // What comes next may draw from the results, read them back or write over the inputs.
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                  GL_BUFFER_UPDATE_BARRIER_BIT);
  glUseProgram(0);
  if (state_->debug) glPopDebugGroup();
}

void Executor::read(Buffer buffer, std::span<std::byte> bytes) const {
  if (bytes.empty()) return;
  glBindBuffer(GL_COPY_READ_BUFFER, handle(buffer));
  glGetBufferSubData(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(bytes.size()), bytes.data());
}

uint32_t Executor::handle(Buffer buffer) const {
  return state_ ? state_->buffers[static_cast<size_t>(buffer)] : 0;
}

}  // namespace furrow::gl
