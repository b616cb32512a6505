#pragma once

// How long the stages of a picture take.

#include <chrono>
#include <string_view>
#include <vector>

namespace furrow::preview {

struct StageTime {
  std::string_view name;  // a literal
  double milliseconds = 0.0;
};
using StageTimes = std::vector<StageTime>;

inline void addTime(StageTimes& times, std::string_view name, double milliseconds) {
  for (StageTime& stage : times)
    if (stage.name == name) {
      stage.milliseconds += milliseconds;
      return;
    }
  times.push_back({name, milliseconds});
}

// On the CPU's clock: adds the time since the last call to the stage of this name. With no times to fill it
// does nothing.
class StageClock {
 public:
  explicit StageClock(StageTimes* times) : times_(times) {}

  void end(std::string_view name) {
    if (!times_) return;
    const auto now = std::chrono::steady_clock::now();
    const double spent = std::chrono::duration<double, std::milli>(now - begin_).count();
    begin_ = now;
    addTime(*times_, name, spent);
  }

 private:
  StageTimes* times_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace furrow::preview
