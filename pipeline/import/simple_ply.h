#pragma once

#include <cstdint>
#include <vector>

namespace furrow::pipeline {

// The PLY file with nothing but what furrow uses: of the vertices position, normal, UV and colour, of the
// faces their corners; values and encoding as they stand. OpenMesh's reader trusts the header and takes what
// it does not know, lists above all, for something else. Throws std::runtime_error for a header that is
// damaged, a file that is cut off, and one without faces.
std::vector<uint8_t> simplePly(const std::vector<uint8_t>& bytes);

}  // namespace furrow::pipeline
