#include "editor/preview/gl_objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <string>
#include <vector>

#include "pipeline/error.h"
#include "preview_shaders.h"

namespace furrow::preview {

namespace {

constexpr uint32_t kLargestSide = 4096;
constexpr int kMostErrors = 64;  // a lost context never runs out of them

uint32_t generation = 0;

std::string firstLine(const std::string& log) {
  const size_t begin = log.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || log[begin] == '\0') return "the driver gave no reason";
  return log.substr(begin, log.find_first_of(std::string("\r\n\0", 3), begin) - begin);
}

[[noreturn]] void failProgram(const char* name, const std::string& log) {
  throw pipeline::Error(pipeline::Exit::kEnvironment, "OpenGL",
                        std::string("the shader program ") + name + " does not build: " + firstLine(log),
                        "update the graphics driver");
}

void attach(GLuint program, const char* name, GLenum type, GlslPieces pieces) {
  if (pieces.size() == 0) return;
  std::vector<const char*> text = {"#version 330 core\n", shaders::kScene};
  text.insert(text.end(), pieces.begin(), pieces.end());
  const GLuint shader = glCreateShader(type);
  glShaderSource(shader, static_cast<GLsizei>(text.size()), text.data(), nullptr);
  glCompileShader(shader);
  GLint done = GL_FALSE, length = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
  if (!done) glGetShaderInfoLog(shader, length, nullptr, log.data());
  glAttachShader(program, shader);
  glDeleteShader(shader);  // lives on while attached
  if (!done) failProgram(name, log);
}

}  // namespace

void giveUpObjects() {
  ++generation;
}

uint32_t objectGeneration() {
  return generation;
}

GlObject::GlObject(GlKind kind) : kind_(kind), generation_(generation) {
  switch (kind) {
    case GlKind::kBuffer:
      glGenBuffers(1, &name_);
      break;
    case GlKind::kFramebuffer:
      glGenFramebuffers(1, &name_);
      break;
    case GlKind::kProgram:
      name_ = glCreateProgram();
      break;
    case GlKind::kRenderbuffer:
      glGenRenderbuffers(1, &name_);
      break;
    case GlKind::kTexture:
      glGenTextures(1, &name_);
      break;
    case GlKind::kVertexArray:
      glGenVertexArrays(1, &name_);
      break;
  }
}

GlObject::~GlObject() {
  if (name_ == 0 || generation_ != generation) return;
  switch (kind_) {
    case GlKind::kBuffer:
      glDeleteBuffers(1, &name_);
      break;
    case GlKind::kFramebuffer:
      glDeleteFramebuffers(1, &name_);
      break;
    case GlKind::kProgram:
      glDeleteProgram(name_);
      break;
    case GlKind::kRenderbuffer:
      glDeleteRenderbuffers(1, &name_);
      break;
    case GlKind::kTexture:
      glDeleteTextures(1, &name_);
      break;
    case GlKind::kVertexArray:
      glDeleteVertexArrays(1, &name_);
      break;
  }
}

GlObject makeProgram(const char* name, GlslPieces vertex, GlslPieces geometry, GlslPieces fragment) {
  GlObject program(GlKind::kProgram);
  attach(program, name, GL_VERTEX_SHADER, vertex);
  attach(program, name, GL_GEOMETRY_SHADER, geometry);
  attach(program, name, GL_FRAGMENT_SHADER, fragment);
  glLinkProgram(program);
  GLint done = GL_FALSE, length = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &done);
  if (!done) {
    glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
    glGetProgramInfoLog(program, length, nullptr, log.data());
    failProgram(name, log);
  }
  const auto bindBlock = [&](const char* block, GLuint slot) {
    const GLuint index = glGetUniformBlockIndex(program, block);
    if (index != GL_INVALID_INDEX) glUniformBlockBinding(program, index, slot);
  };
  bindBlock("Scene", kSceneSlot);
  bindBlock("Material", kMaterialSlot);
  return program;
}

GlObject makeBuffer(std::span<const std::byte> bytes) {
  GlObject buffer(GlKind::kBuffer);
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer);
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes.size()), bytes.data(), GL_STATIC_DRAW);
  return buffer;
}

void refill(uint32_t buffer, std::span<const std::byte> bytes) {
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer);
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes.size()), bytes.data(), GL_STREAM_DRAW);
}

PictureTarget::PictureTarget(uint32_t width, uint32_t height) : width_(width), height_(height) {
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide)
    throw pipeline::Error(pipeline::Exit::kBadUsage, "picture", "the size " + size + " is out of range",
                          "ask for 1x1 to 4096x4096");
  for (int i = 0; i < kMostErrors && glGetError() != GL_NO_ERROR; ++i) {
  }
  samples_ = GlObject(GlKind::kRenderbuffer);
  depth_ = GlObject(GlKind::kRenderbuffer);
  drawn_ = GlObject(GlKind::kFramebuffer);
  texture_ = GlObject(GlKind::kTexture);
  resolved_ = GlObject(GlKind::kFramebuffer);
  const auto w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
  GLint samples = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &samples);
  samples = std::min(samples, 4);

  glBindFramebuffer(GL_FRAMEBUFFER, drawn_);
  glBindRenderbuffer(GL_RENDERBUFFER, samples_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_SRGB8_ALPHA8, w, h);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, samples_);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, w, h);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  const bool drawable = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;

  glBindFramebuffer(GL_FRAMEBUFFER, resolved_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, w, h, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  // A window shows the bytes as they are.
  if (epoxy_has_gl_extension("GL_EXT_texture_sRGB_decode"))
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SRGB_DECODE_EXT, GL_SKIP_DECODE_EXT);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_, 0);
  const bool resolvable = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (!drawable || !resolvable || glGetError() != GL_NO_ERROR)
    throw pipeline::Error(pipeline::Exit::kEnvironment, "OpenGL", "no memory for a picture of " + size,
                          "ask for a smaller one");
}

void PictureTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_);
  glViewport(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
}

uint32_t PictureTarget::resolve() const {
  const auto w = static_cast<GLint>(width_), h = static_cast<GLint>(height_);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, drawn_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_);
  glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return texture_;
}

void PictureTarget::readPixels(uint8_t* rgba) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), GL_RGBA, GL_UNSIGNED_BYTE,
               rgba);
}

}  // namespace furrow::preview
