#include "program.h"

#include <algorithm>
#include <string>

namespace furrow::gl {

namespace {

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

void attach(GLuint program, GLenum type, const char* source, const char* label, Status& status) {
  if (!source || !status.ok()) return;
  const GLuint stage = glCreateShader(type);
  glShaderSource(stage, 1, &source, nullptr);
  glCompileShader(stage);
  GLint done = GL_FALSE;
  glGetShaderiv(stage, GL_COMPILE_STATUS, &done);
  if (!done)
    status = Status::error(StatusCode::kUnavailable, "shader of %s: %s", label,
                           firstLine(stage, glGetShaderiv, glGetShaderInfoLog).c_str());
  glAttachShader(program, stage);
  glDeleteShader(stage);  // lives on while attached
}

// GLSL 3.30 cannot say these in its text.
void bindSlots(GLuint program, const Item& item) {
  glUseProgram(program);
  for (const Binding& binding : item.bindings) {
    if (binding.access == Access::kUniform) {
      const GLuint block = glGetUniformBlockIndex(program, binding.name);
      if (block != GL_INVALID_INDEX) glUniformBlockBinding(program, block, binding.slot);
    } else if (binding.access == Access::kFloats || binding.access == Access::kWords ||
               binding.access == Access::kSums || binding.access == Access::kOtherSums) {
      glUniform1i(glGetUniformLocation(program, binding.name), static_cast<GLint>(binding.slot));
    }
  }
  glUniform1ui(glGetUniformLocation(program, "item"), item.slice);
  glUseProgram(0);
}

}  // namespace

GLuint makeProgram(const Item& item, Status& status) {
  const ShaderSource& source = shaderSource(item.shader);
  const GLuint program = glCreateProgram();
  attach(program, GL_COMPUTE_SHADER, source.compute, item.label, status);
  attach(program, GL_VERTEX_SHADER, source.vertex, item.label, status);
  attach(program, GL_GEOMETRY_SHADER, source.geometry, item.label, status);
  attach(program, GL_FRAGMENT_SHADER, source.fragment, item.label, status);
  if (!item.captured.empty()) {
    const auto buffers = std::count_if(item.bindings.begin(), item.bindings.end(),
                                       [](const Binding& b) { return b.access == Access::kCapture; });
    glTransformFeedbackVaryings(program, static_cast<GLsizei>(item.captured.size()), item.captured.data(),
                                buffers > 1 ? GL_SEPARATE_ATTRIBS : GL_INTERLEAVED_ATTRIBS);
  }
  if (status.ok()) {
    glLinkProgram(program);
    GLint done = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &done);
    if (!done)
      status = Status::error(StatusCode::kUnavailable, "shader of %s: %s", item.label,
                             firstLine(program, glGetProgramiv, glGetProgramInfoLog).c_str());
  }
  if (status.ok()) {
    bindSlots(program, item);
    return program;
  }
  glDeleteProgram(program);
  return 0;
}

}  // namespace furrow::gl
