#pragma once

// The two compressions of geometry that glTF files use: KHR_draco_mesh_compression and
// EXT_meshopt_compression. Bytes come from a file: what is out of bounds or would not decode throws
// std::runtime_error.

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace furrow::pipeline {

// Attribute of a Draco mesh, one tightly packed element a vertex, in the component type it was encoded from
// (glTF's number for it).
struct DracoAttribute {
  int component_type = 0;
  uint32_t components = 0;
  std::vector<uint8_t> bytes;
};

struct DracoMesh {
  size_t vertices = 0;
  std::vector<uint32_t> indices;  // a triangle list, all below `vertices`
  std::map<std::string, DracoAttribute> attributes;
};

// `ids`: Draco's unique id of every attribute that is wanted.
DracoMesh decodeDraco(std::span<const uint8_t> bytes, const std::map<std::string, int>& ids);

// `count` elements of `stride` bytes. mode: ATTRIBUTES, TRIANGLES or INDICES; filter: NONE, OCTAHEDRAL,
// QUATERNION or EXPONENTIAL.
std::vector<uint8_t> decodeMeshopt(std::span<const uint8_t> bytes, size_t count, size_t stride,
                                   const std::string& mode, const std::string& filter);

}  // namespace furrow::pipeline
