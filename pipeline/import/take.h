#pragma once

// Performance takes: weights of face shapes over time, as CSV in the columns that Live Link Face writes.

#include <filesystem>
#include <string>
#include <vector>

namespace furrow::pipeline {

struct Take {
  std::vector<std::string> shapes;  // names of the columns behind Timecode and BlendshapeCount
  std::vector<double> times;        // seconds from the first frame, strictly increasing, at least one
  std::vector<float> weights;       // shapes.size() a frame

  // Weights at `time`, linear between frames, clamped to the take.
  std::vector<float> at(double time) const;
};

// Columns: Timecode (HH:MM:SS:FF.fraction), BlendshapeCount (not read), then one a shape. A timecode does not
// say its rate: it is the first of 24, 25, 30, 48, 50, 60, 100, 120 above the largest frame number if a
// second ends within the take, else 60. Where two frames have one timecode the later counts. Throws Error:
// kBadData with the line at fault.
Take readTake(const std::filesystem::path& file);

// The same of a text that is in memory, as if it stood in `file`.
Take parseTake(std::string text, const std::filesystem::path& file);

}  // namespace furrow::pipeline
