#pragma once

// One part of an asset: from the integers the file holds to the floats the jobs read. The pipeline packs with
// the same code, so that what it bakes from is what a game will see.

#include <cstddef>
#include <vector>

#include "furrow/status.h"
#include "furrow/types.h"

namespace furrow {

namespace format {
struct Part;
struct Stream;
}  // namespace format

struct PartGeometry {
  std::vector<Float3> positions;  // offset + step * n
  Float3 position_offset;
  float position_step = 0.0f;
  std::vector<Float3> normals;
  std::vector<Float4> tangents;
  std::vector<Float2> uvs;
  std::vector<uint16_t> joints, weights;  // `influences` a vertex, joints relative to the part's palette
  std::vector<uint32_t> source;           // relative to the part's first source vertex
  std::vector<uint32_t> indices;          // relative to the part's first vertex
};

// Decodes and checks a part: every attribute present once with the right number of components, indices and
// joints in range, floats finite, `source` a permutation, weights summing to 65535 and padded with zeros to
// `influences`.
Status decodePart(const format::Part& part, uint32_t influences, PartGeometry& out);

// Bytes that one byte of a stream may stand for, so that a short file asks for little memory: what a header
// of the vertex codec tells of, 4 groups of 16. The cook gives no stream to the entropy coder that would need
// fewer.
inline constexpr size_t kMostUnpacked = 64;

// A stream of `stride`-byte elements whose count must be `count`; null is a stream of no elements.
// checkStream() comes before memory is taken for the elements: whether there are bytes enough for so many.
Status checkStream(const format::Stream* stream, uint32_t stride, size_t count);
Status decodeStream(const format::Stream* stream, uint32_t stride, size_t count, void* out);
uint32_t streamCount(const format::Stream* stream);

// Unit vectors as two integers of `bits` bits (octahedral map).
Float3 decodeOctahedral(uint32_t u, uint32_t v, uint32_t bits);
void encodeOctahedral(Float3 unit, uint32_t bits, uint32_t& u, uint32_t& v);

// Two unit vectors that make a right-handed basis with the unit normal (Duff et al. 2017, Building an
// Orthonormal Basis, Revisited).
void tangentBasis(Float3 normal, Float3& tangent, Float3& bitangent);

// A tangent as its angle about the normal and, in the lowest bit, the sign of the bitangent.
Float4 decodeTangent(Float3 normal, uint32_t code, uint32_t bits);
uint32_t encodeTangent(Float3 normal, Float4 tangent, uint32_t bits);

}  // namespace furrow
