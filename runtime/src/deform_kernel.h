#pragma once

#include "furrow/jobs.h"

namespace furrow {

inline constexpr uint32_t kMostInfluences = 255;  // of an asset: so much room the kernels have

// Skins vertices [begin, end) of a job from morphed rest positions and normals (null without normals), which
// are an asset's or already lie in the job's outputs. One function an instruction set (targets.h).
using DeformRun = void (*)(const DeformJob& job, const Float3* positions, const Float3* normals,
                           uint32_t begin, uint32_t end);
DeformRun deformRun(Simd simd);

}  // namespace furrow
