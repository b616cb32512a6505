#pragma once

// A vertex animation from numbered mesh files, as cloth simulations write them.

#include <string>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct Sequence {
  std::filesystem::path pattern;  // files; * and ? stand for any text and any letter of the file's name
  std::filesystem::path base;     // relaxed mesh, with the UVs and materials; empty: the first frame
  double fps = 24.0;              // frames a second, > 0

  const std::filesystem::path& name() const { return base.empty() ? pattern : base; }  // for messages
};

// The files of a sequence, numbers in their names in the order of their values.
std::vector<std::filesystem::path> sequenceFiles(const std::filesystem::path& pattern);

// The base with a clip "sequence". Every frame is a morph target named as its file, to which the clip blends
// linearly; travel that is longer than the mesh itself moves the node, so that deltas keep their precision.
// All files are OBJ, PLY, STL or OFF and have the same faces; UVs, normals and materials are the base's,
// normals follow the faces. Reads one frame at a time. Throws Error as import() does, and kBadData where no
// file matches, where a frame's faces differ (naming the frame and how), and where the frames together are
// more than 2^26 vertices or 2048 frames.
SourceScene importSequence(const Sequence& sequence);

}  // namespace furrow::pipeline
