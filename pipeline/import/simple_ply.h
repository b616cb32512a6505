#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace furrow::pipeline {

struct SimplePly {
  std::vector<uint8_t> bytes;
  // UVs of the corners of all faces, if the file has them by corner (MeshLab, photogrammetry); a face without
  // has zeros.
  std::vector<float> corner_uvs;      // u and v a corner
  std::vector<std::string> textures;  // names of image files, as comments have them
};

// The PLY file with nothing but what furrow uses: of the vertices position, normal, UV and colour, of the
// faces their corners, triangle strips cut into faces; vertices first; values and encoding as they stand, but
// whole numbers of positions are floats.
// OpenMesh's reader trusts the header and takes what it does not know, lists above all, for something else.
// Throws std::runtime_error for a header that is damaged, a file that is cut off, and one without faces.
SimplePly simplePly(const std::vector<uint8_t>& bytes);

// Its textures alone, from the header.
std::vector<std::string> plyTextures(const std::vector<uint8_t>& bytes);

}  // namespace furrow::pipeline
