#pragma once

// How long the stages of a picture take, on the CPU's clock.

#include <chrono>
#include <string_view>
#include <vector>

namespace furrow::preview {

struct StageTime {
  std::string_view name;  // a literal
  double milliseconds = 0.0;
};
using StageTimes = std::vector<StageTime>;

// Adds the time since the last call to the stage of this name. With no times to fill it does nothing.
class StageClock {
 public:
  explicit StageClock(StageTimes* times) : times_(times) {}

  void end(std::string_view name) {
    if (!times_) return;
    const auto now = std::chrono::steady_clock::now();
    const double spent = std::chrono::duration<double, std::milli>(now - begin_).count();
    begin_ = now;
    for (StageTime& stage : *times_)
      if (stage.name == name) {
        stage.milliseconds += spent;
        return;
      }
    times_->push_back({name, spent});
  }

 private:
  StageTimes* times_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace furrow::preview
