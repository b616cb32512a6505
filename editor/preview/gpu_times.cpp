#include "editor/preview/gpu_times.h"

#include <epoxy/gl.h>

#include <cstring>

namespace furrow::preview {

bool isSoftwareGl() {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return renderer && (std::strstr(renderer, "llvmpipe") || std::strstr(renderer, "softpipe"));
}

GpuTimes::GpuTimes(StageTimes* times) : times_(times), clock_(times), queried_(times && !isSoftwareGl()) {
  if (queried_) mark();
}

GpuTimes::~GpuTimes() {
  if (!queries_.empty()) glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
}

void GpuTimes::mark() {
  glGenQueries(1, &queries_.emplace_back(0));
  glQueryCounter(queries_.back(), GL_TIMESTAMP);
}

void GpuTimes::end(std::string_view name) {
  if (!times_) return;
  if (queried_) {
    mark();
    names_.push_back(name);
    return;
  }
  glFinish();
  clock_.end(name);
}

void GpuTimes::read() {
  if (!queried_) return;
  GLuint64 before = 0;
  glGetQueryObjectui64v(queries_.front(), GL_QUERY_RESULT, &before);
  for (size_t i = 0; i < names_.size(); ++i) {
    GLuint64 now = before;
    glGetQueryObjectui64v(queries_[i + 1], GL_QUERY_RESULT, &now);
    addTime(*times_, names_[i], 1e-6 * static_cast<double>(now - before));
    before = now;
  }
}

}  // namespace furrow::preview
