#pragma once

// Geometry of one part as the file holds it: integers, carried by Draco or by plain streams. Both decode to
// the same floats.

#include <flatbuffers/flatbuffers.h>

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

#include "furrow_generated.h"
#include "part_geometry.h"
#include "pipeline/pack/geometry_codec.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct PackedStream {
  format::Codec codec{};
  uint32_t stride = 4, count = 0;
  std::vector<uint8_t> bytes;
};

struct PackedAttribute {
  format::Semantic semantic{};
  uint32_t components = 1, bits = 16;
  std::vector<float> offset;
  float step = 0.0f;
  std::vector<uint32_t> values;  // components a vertex
  PackedStream stream;           // of the values that Draco has not got
};

struct PackedPart {
  uint32_t vertices = 0, triangles = 0;
  std::vector<PackedAttribute> attributes;
  std::vector<uint8_t> draco;  // empty: raw
  PackedStream indices;        // raw
  // Of the part, to be filled by the cook.
  std::string mesh, material;
  uint32_t palette_begin = 0, palette_count = 1, texture_set = 0xffffffffu, base_maps = 0xffffffffu;
  glm::vec4 base_color{1.0f};
  float roughness = 0.5f;
  glm::dmat4 rest{1.0};
  bool has_normals = false, has_uvs = false;
};

// Of the lattice that positions are put on: a power of two, at most 1/64 of the short edges and 1/65535 of
// the extent, as far as a float's 24 bits allow; every lattice contains the coarser ones. 0 for a single
// place at the origin.
float positionStep(std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

// A primitive in integers: positions in steps of `position_step`, see above, normals and tangents (unit) to
// 10 bits, UVs and weights to 16.
PackedPart quantizePart(const Primitive& primitive, std::span<const glm::vec3> normals,
                        std::span<const glm::vec4> tangents, uint32_t palette_count, float position_step);

// Encodes what `quantized` makes, which is asked again where Draco fails, so that nothing is kept twice
// meanwhile. With Draco the vertices get a new order and triangles with a corner twice are dropped. `decoded`
// is what the runtime will make of it, with influencesOf(part) joints a vertex. Values are given back.
PackedPart packGeometry(const std::function<PackedPart()>& quantized, const std::vector<uint32_t>& indices,
                        GeometryCodec codec, PartGeometry& decoded);

flatbuffers::Offset<format::Part> writePart(flatbuffers::FlatBufferBuilder& builder, const PackedPart& part);

uint32_t influencesOf(const PackedPart& part);

// Length that one edge in twenty of those that have any is shorter than; 0 if none has.
double shortEdge(std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

// The upper three rows, row-major, as the file and the runtime's Affine hold a matrix.
std::vector<float> affineRows(const glm::dmat4& matrix);

// A stream through the codec; where that is MeshoptVertex, through the entropy coder instead if that takes a
// twentieth less. `stride` is a multiple of 4.
PackedStream packStream(const void* data, uint32_t stride, size_t count,
                        format::Codec codec = format::Codec::MeshoptVertex);

flatbuffers::Offset<format::Stream> writeStream(flatbuffers::FlatBufferBuilder& builder,
                                                const PackedStream& stream);

}  // namespace furrow::pipeline
