#include "pipeline/pack/geometry.h"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>
#include <utility>

#include "pipeline/pack/entropy_encoder.h"
#include "pipeline/release.h"
#include "rest_surface.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kNormalBits = 10;
constexpr uint32_t kTangentBits = 11;
constexpr uint32_t kLeastPositionBits = 16, kPositionBits = 24;  // a float holds 24
constexpr int kDracoSpeed = 4;
// Of a stream's bytes: the entropy coder takes up to three times as long to load.
constexpr size_t kWorthIt = 20;

// Integers of at most `bits` bits on the lattice of `step`; 0: as fine as they allow. A step that is given is
// a power of two, and the offset a multiple of it.
template <typename Vector>
PackedAttribute quantize(format::Semantic semantic, const std::vector<Vector>& values, uint32_t bits,
                         float step = 0.0f) {
  PackedAttribute attribute{semantic, static_cast<uint32_t>(Vector::length()), bits, {}, step, {}, {}};
  Vector lowest = values.front(), highest = values.front();
  for (const Vector& v : values) {
    lowest = glm::min(lowest, v);
    highest = glm::max(highest, v);
  }
  double range = 0.0;
  for (int c = 0; c < Vector::length(); ++c) {
    attribute.offset.push_back(step > 0.0f ? std::floor(lowest[c] / step) * step : lowest[c]);
    range = std::max(range, double{highest[c]} - double{lowest[c]});
  }
  attribute.values.reserve(values.size() * Vector::length());
  const uint32_t most = (1u << bits) - 1;
  if (step == 0.0f) attribute.step = static_cast<float>(range / most);
  for (const Vector& v : values)
    for (size_t c = 0; c < attribute.components; ++c)
      attribute.values.push_back(
          attribute.step > 0.0f ? std::min(most, static_cast<uint32_t>(std::lround(
                                                     (double{v[static_cast<int>(c)]} - attribute.offset[c]) /
                                                     double{attribute.step})))
                                : 0u);
  return attribute;
}

void packSkin(const Primitive& primitive, PackedPart& part) {
  // With one matrix all weight is its own; a mesh that a node shows without a skin may have joints yet.
  const uint32_t influences = part.palette_count > 1 ? primitive.influences : 0;
  const uint32_t most = std::max(1u, influences);
  uint32_t used = 1;
  std::vector<uint16_t> shares(size_t{part.vertices} * most, 0);
  std::vector<float> parts_of_one(most, 0.0f);
  UnitShares unit_shares;
  for (size_t v = 0; v < part.vertices; ++v) {
    for (uint32_t k = 0; k < influences; ++k) parts_of_one[k] = primitive.weights[v * most + k];
    if (influences == 0) parts_of_one[0] = 1.0f;
    unit_shares(parts_of_one, {&shares[v * most], most});
    used = std::max(used,
                    static_cast<uint32_t>(most - std::count(&shares[v * most], &shares[v * most] + most, 0)));
  }
  PackedAttribute joints{format::Semantic::Joints, used, 16, {}, 1.0f, {}, {}};
  PackedAttribute weights{format::Semantic::Weights, used, 16, {}, 1.0f, {}, {}};
  joints.values.reserve(size_t{part.vertices} * used);
  weights.values.reserve(size_t{part.vertices} * used);
  for (size_t v = 0; v < part.vertices; ++v) {
    uint32_t written = 0;
    for (uint32_t k = 0; k < most; ++k) {
      if (shares[v * most + k] == 0) continue;
      joints.values.push_back(influences ? primitive.joints[v * most + k] : 0u);
      weights.values.push_back(shares[v * most + k]);
      ++written;
    }
    for (; written < used; ++written) {
      joints.values.push_back(0);
      weights.values.push_back(0);
    }
  }
  part.attributes.push_back(std::move(joints));
  part.attributes.push_back(std::move(weights));
}

// Whether each vertex has a triangle with three different corners: Edgebreaker loses the others.
std::vector<bool> inTriangles(uint32_t vertices, const std::vector<uint32_t>& indices) {
  std::vector<bool> found(vertices);
  for (size_t i = 0; i < indices.size(); i += 3) {
    const uint32_t a = indices[i], b = indices[i + 1], c = indices[i + 2];
    if (a != b && b != c && c != a) found[a] = found[b] = found[c] = true;
  }
  return found;
}

// Leaves the attributes the values of the vertices that Draco has not got.
bool encodeDraco(PackedPart& part, const std::vector<uint32_t>& indices, int method) {
  const std::vector<bool> kept = method == draco::MESH_EDGEBREAKER_ENCODING
                                     ? inTriangles(part.vertices, indices)
                                     : std::vector<bool>(part.vertices, true);
  draco::Mesh mesh;
  mesh.set_num_points(part.vertices);
  for (PackedAttribute& source : part.attributes) {
    draco::GeometryAttribute shape;
    const auto type = source.semantic == format::Semantic::Position ? draco::GeometryAttribute::POSITION
                      : source.semantic == format::Semantic::Uv     ? draco::GeometryAttribute::TEX_COORD
                                                                    : draco::GeometryAttribute::GENERIC;
    shape.Init(type, nullptr, static_cast<uint8_t>(source.components), draco::DT_UINT32, false,
               4 * source.components, 0);
    const int id = mesh.AddAttribute(shape, true, part.vertices);
    draco::PointAttribute* attribute = mesh.attribute(id);
    const std::vector<uint32_t> values = std::exchange(source.values, {});
    attribute->buffer()->Write(0, values.data(), 4 * values.size());
    for (size_t i = 0; i < values.size(); ++i)
      if (!kept[i / source.components]) source.values.push_back(values[i]);
    attribute->set_unique_id(static_cast<uint32_t>(source.semantic));
  }
  mesh.SetNumFaces(indices.size() / 3);
  for (uint32_t face = 0; face < mesh.num_faces(); ++face)
    mesh.SetFace(draco::FaceIndex(face),
                 {draco::PointIndex(indices[3 * face]), draco::PointIndex(indices[3 * face + 1]),
                  draco::PointIndex(indices[3 * face + 2])});
  draco::Encoder encoder;
  // One connectivity for all attributes: two thirds of the memory and a few percent more bytes.
  encoder.options().SetGlobalBool("split_mesh_on_seams", true);
  encoder.SetSpeedOptions(kDracoSpeed, kDracoSpeed);
  encoder.SetEncodingMethod(method);
  encoder.SetTrackEncodedProperties(true);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return false;
  part.triangles = static_cast<uint32_t>(encoder.num_encoded_faces());
  part.draco.assign(buffer.data(), buffer.data() + buffer.size());
  return true;
}

// Puts streams in the place of the values.
Status packAndDecode(PackedPart& part, uint32_t influences, PartGeometry& out) {
  for (PackedAttribute& attribute : part.attributes) {
    attribute.stream = packStream(attribute.values.data(), 4, attribute.values.size());
    release(attribute.values);
  }
  flatbuffers::FlatBufferBuilder builder;
  builder.Finish(writePart(builder, part));
  return decodePart(*flatbuffers::GetRoot<format::Part>(builder.GetBufferPointer()), influences, out);
}

}  // namespace

PackedPart quantizePart(const Primitive& primitive, std::span<const glm::vec3> normals,
                        std::span<const glm::vec4> tangents, uint32_t palette_count, float position_step) {
  PackedPart part;
  part.palette_count = palette_count;
  part.vertices = static_cast<uint32_t>(primitive.positions.size());
  part.triangles = static_cast<uint32_t>(primitive.indices.size() / 3);
  part.attributes.push_back(
      quantize(format::Semantic::Position, primitive.positions, kPositionBits, position_step));
  PackedAttribute& position = part.attributes.back();
  position.bits = std::bit_width(*std::max_element(position.values.begin(), position.values.end()) | 1u);
  if (!primitive.uvs.empty()) part.attributes.push_back(quantize(format::Semantic::Uv, primitive.uvs, 16));

  PackedAttribute normal{format::Semantic::Normal, 2, kNormalBits, {}, 1.0f, {}, {}};
  PackedAttribute tangent{format::Semantic::Tangent, 1, kTangentBits, {}, 1.0f, {}, {}};
  PackedAttribute source{format::Semantic::Source, 1, 30, {}, 1.0f, {}, {}};
  normal.values.reserve(size_t{2} * part.vertices);
  tangent.values.reserve(part.vertices);
  source.values.reserve(part.vertices);
  for (uint32_t v = 0; v < part.vertices; ++v) {
    uint32_t x, y;
    encodeOctahedral({normals[v].x, normals[v].y, normals[v].z}, kNormalBits, x, y);
    normal.values.insert(normal.values.end(), {x, y});
    tangent.values.push_back(encodeTangent(decodeOctahedral(x, y, kNormalBits),
                                           {tangents[v].x, tangents[v].y, tangents[v].z, tangents[v].w},
                                           kTangentBits));
    source.values.push_back(v);
  }
  part.attributes.push_back(std::move(normal));
  part.attributes.push_back(std::move(tangent));
  part.attributes.push_back(std::move(source));
  packSkin(primitive, part);
  return part;
}

PackedPart packGeometry(const std::function<PackedPart()>& quantized, const std::vector<uint32_t>& indices,
                        GeometryCodec codec, PartGeometry& decoded) {
  if (codec == GeometryCodec::kDraco)
    for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
      PackedPart part = quantized();
      if (encodeDraco(part, indices, method) && packAndDecode(part, influencesOf(part), decoded).ok())
        return part;
    }
  PackedPart part = quantized();
  part.indices = packStream(indices.data(), 4, indices.size(), format::Codec::MeshoptSequence);
  if (const Status status = packAndDecode(part, influencesOf(part), decoded); !status.ok())
    throw std::runtime_error(status.message);
  return part;
}

flatbuffers::Offset<format::Part> writePart(flatbuffers::FlatBufferBuilder& builder, const PackedPart& part) {
  std::vector<flatbuffers::Offset<format::Attribute>> attributes;
  const bool raw = part.draco.empty();
  for (const PackedAttribute& attribute : part.attributes)
    attributes.push_back(format::CreateAttribute(
        builder, attribute.semantic, static_cast<uint8_t>(attribute.components),
        static_cast<uint8_t>(attribute.bits), builder.CreateVector(attribute.offset), attribute.step,
        attribute.stream.count == 0 ? flatbuffers::Offset<format::Stream>()
                                    : writeStream(builder, attribute.stream)));
  const auto indices = raw ? writeStream(builder, part.indices) : flatbuffers::Offset<format::Stream>();
  const format::Color color(part.base_color.r, part.base_color.g, part.base_color.b, part.base_color.a);
  return format::CreatePart(builder, builder.CreateString(part.mesh), builder.CreateString(part.material),
                            part.vertices, part.triangles, builder.CreateVector(attributes),
                            builder.CreateVector(part.draco), indices, part.palette_begin, part.palette_count,
                            part.texture_set, &color, builder.CreateVector(affineRows(part.rest)),
                            part.has_normals, part.has_uvs, part.roughness, part.base_maps);
}

double shortEdge(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
  std::vector<float> lengths;
  lengths.reserve(indices.size());
  for (size_t i = 0; i < indices.size(); ++i) {
    const size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const float length = glm::distance(positions[indices[i]], positions[indices[next]]);
    if (length > 0.0f) lengths.push_back(length);
  }
  if (lengths.empty()) return 0.0;
  std::nth_element(lengths.begin(), lengths.begin() + lengths.size() / 20, lengths.end());
  return lengths[lengths.size() / 20];
}

float positionStep(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
  double largest = 0.0, range = 0.0;
  for (int c = 0; c < 3; ++c) {
    const auto [low, high] =
        std::minmax_element(positions.begin(), positions.end(),
                            [c](const glm::vec3& a, const glm::vec3& b) { return a[c] < b[c]; });
    range = std::max(range, double{(*high)[c]} - double{(*low)[c]});
    largest = std::max({largest, std::abs(double{(*low)[c]}), std::abs(double{(*high)[c]})});
  }
  // So that offset, integer and their sum are floats to the bit.
  const double least = largest * std::exp2(2.0 - kPositionBits);
  double wanted = range / ((1u << kLeastPositionBits) - 1);
  if (const double edge = shortEdge(positions, indices); edge > 0.0) wanted = std::min(wanted, edge / 64.0);
  if (!(std::max(wanted, least) >= double{std::numeric_limits<float>::min()})) return 0.0f;
  return static_cast<float>(wanted > least ? std::exp2(std::floor(std::log2(wanted)))
                                           : std::exp2(std::ceil(std::log2(least))));
}

std::vector<float> affineRows(const glm::dmat4& matrix) {
  std::vector<float> rows;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) rows.push_back(static_cast<float>(matrix[column][row]));
  return rows;
}

uint32_t influencesOf(const PackedPart& part) {
  for (const PackedAttribute& attribute : part.attributes)
    if (attribute.semantic == format::Semantic::Joints) return attribute.components;
  return 1;
}

PackedStream packStream(const void* data, uint32_t stride, size_t count, format::Codec codec) {
  std::vector<uint8_t> bytes;
  if (count > 0 && codec == format::Codec::MeshoptSequence) {
    const auto* words = static_cast<const uint32_t*>(data);
    bytes.resize(
        meshopt_encodeIndexSequenceBound(count, *std::max_element(words, words + count) + size_t{1}));
    bytes.resize(meshopt_encodeIndexSequence(bytes.data(), bytes.size(), words, count));
  } else if (count > 0) {
    bytes.resize(meshopt_encodeVertexBufferBound(count, stride));
    bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), data, count, stride));
    std::vector<uint8_t> coded = encodeEntropyStream(static_cast<const uint8_t*>(data), count, stride);
    if (coded.size() + bytes.size() / kWorthIt < bytes.size() &&
        count * stride <= kMostUnpacked * coded.size()) {
      bytes = std::move(coded);
      codec = format::Codec::Entropy;
    }
  }
  return {codec, stride, static_cast<uint32_t>(count), std::move(bytes)};
}

flatbuffers::Offset<format::Stream> writeStream(flatbuffers::FlatBufferBuilder& builder,
                                                const PackedStream& stream) {
  return format::CreateStream(builder, stream.codec, stream.stride, stream.count,
                              builder.CreateVector(stream.bytes));
}

}  // namespace furrow::pipeline
