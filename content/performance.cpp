#include "content/performance.h"

#include <algorithm>

#include "content/expressions.h"
#include "content/surface_mesh.h"

namespace furrow::content {

// The expressions one after another, each up, held and down.
Clip performance(uint32_t node) {
  struct Cue {
    double begin, end;
    std::vector<std::pair<std::string_view, double>> weights;
  };
  const std::vector<Cue> cues = {
      {0.3,
       1.8,
       {{"browInnerUp", 1},
        {"browOuterUpLeft", 0.8},
        {"browOuterUpRight", 0.8},
        {"eyeWideLeft", 0.7},
        {"eyeWideRight", 0.7}}},
      {1.7,
       3.0,
       {{"browDownLeft", 1},
        {"browDownRight", 1},
        {"eyeSquintLeft", 0.5},
        {"eyeSquintRight", 0.5},
        {"mouthFrownLeft", 0.6},
        {"mouthFrownRight", 0.6},
        {"mouthShrugLower", 0.8}}},
      {3.0, 3.4, {{"eyeBlinkLeft", 1}, {"eyeBlinkRight", 1}}},
      {3.3,
       4.8,
       {{"mouthSmileLeft", 1},
        {"mouthSmileRight", 1},
        {"cheekSquintLeft", 0.8},
        {"cheekSquintRight", 0.8},
        {"eyeSquintLeft", 0.8},
        {"eyeSquintRight", 0.8},
        {"mouthUpperUpLeft", 0.5},
        {"mouthUpperUpRight", 0.5},
        {"mouthLowerDownLeft", 0.4},
        {"mouthLowerDownRight", 0.4}}},
      {4.8,
       5.9,
       {{"noseSneerLeft", 1},
        {"noseSneerRight", 1},
        {"browDownLeft", 0.6},
        {"browDownRight", 0.6},
        {"mouthUpperUpLeft", 0.6},
        {"mouthUpperUpRight", 0.6}}},
      {5.9,
       7.2,
       {{"jawOpen", 1},
        {"browInnerUp", 0.8},
        {"browOuterUpLeft", 1},
        {"browOuterUpRight", 1},
        {"eyeWideLeft", 1},
        {"eyeWideRight", 1}}},
      {7.2, 8.2, {{"mouthPucker", 1}, {"cheekPuff", 0.3}}},
      {8.2,
       9.1,
       {{"mouthSmileLeft", 0.9}, {"eyeBlinkLeft", 1}, {"cheekSquintLeft", 0.9}, {"browOuterUpRight", 0.7}}},
      {9.1,
       9.8,
       {{"mouthStretchLeft", 0.8},
        {"mouthStretchRight", 0.8},
        {"browInnerUp", 0.6},
        {"eyeBlinkRight", 0.2},
        {"eyeBlinkLeft", 0.2}}},
  };
  constexpr double kSeconds = 10.0;
  constexpr int kKeys = 200;
  const auto names = expressionNames();
  Clip clip;
  clip.name = "performance";
  clip.weights.push_back({node, {}});
  for (int key = 0; key <= kKeys; ++key) {
    const double t = kSeconds * key / kKeys;
    std::vector<float> weights(names.size(), 0.0f);
    for (const Cue& cue : cues) {
      const double edge = 0.4 * (cue.end - cue.begin);
      const double level =
          smoothRamp(cue.begin, cue.begin + edge, t) * smoothRamp(cue.end, cue.end - edge, t);
      for (const auto& [name, weight] : cue.weights) {
        float& w = weights[std::ranges::find(names, name) - names.begin()];
        w = std::max(w, static_cast<float>(level * weight));
      }
    }
    clip.times.push_back(static_cast<float>(t));
    clip.weights[0].weights.push_back(std::move(weights));
  }
  return clip;
}

}  // namespace furrow::content
