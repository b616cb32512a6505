#pragma once

// How long the GPU takes for the stages of a picture: timer queries, or on a software renderer, whose queries
// say nothing, the CPU's clock around glFinish.

#include "editor/preview/stage_times.h"

namespace furrow::preview {

bool isSoftwareGl();  // of the current context

class GpuTimes {
 public:
  // With no times to fill it does nothing. Begins to count.
  explicit GpuTimes(StageTimes* times);
  ~GpuTimes();
  GpuTimes(const GpuTimes&) = delete;
  GpuTimes& operator=(const GpuTimes&) = delete;

  void end(std::string_view name);  // of what was recorded since the last call; a literal
  void read();                      // waits for the GPU and adds what it took

 private:
  void mark();

  StageTimes* times_;
  StageClock clock_;
  bool queried_;
  std::vector<uint32_t> queries_;  // one more than names
  std::vector<std::string_view> names_;
};

}  // namespace furrow::preview
