#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "pipeline/error.h"
#include "pipeline/import/take.h"

// Any text: it is refused with an Error, or makes a take as take.h promises it.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace furrow::pipeline;
  try {
    const Take take = parseTake({data, data + size}, "fuzz.csv");
    bool sound = !take.times.empty() && take.weights.size() == take.shapes.size() * take.times.size();
    for (size_t f = 0; f < take.times.size(); ++f)
      sound &= std::isfinite(take.times[f]) && (f == 0 || take.times[f - 1] < take.times[f]);
    for (const double time : {-1.0, 0.5 * take.times.back(), 1e300})
      for (const float weight : take.at(time)) sound &= std::isfinite(weight);
    if (!sound) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
