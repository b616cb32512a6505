#include "part_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "entropy_codec.h"
#include "furrow_generated.h"
#include "stream_codec.h"

#ifdef FURROW_WITH_DRACO
#include <draco/compression/decode.h>
#endif

namespace furrow {
namespace {

constexpr uint32_t kMaxVertices = 1u << 30;
constexpr uint32_t kSemantics = static_cast<uint32_t>(format::Semantic::MAX) + 1;

// Integers of every attribute of a part, before they become floats.
struct Integers {
  const format::Attribute* attribute[kSemantics] = {};
  std::vector<uint32_t> values[kSemantics];
};

Status bad(const char* what) {
  return Status::error(StatusCode::kBadData, "geometry: %s", what);
}

uint32_t componentsOf(format::Semantic semantic, uint32_t influences) {
  switch (semantic) {
    case format::Semantic::Position:
      return 3;
    case format::Semantic::Normal:
    case format::Semantic::Uv:
      return 2;
    case format::Semantic::Joints:
    case format::Semantic::Weights:
      return influences;
    default:
      return 1;
  }
}

Status findAttributes(const format::Part& part, uint32_t influences, Integers& integers) {
  if (!part.attributes()) return bad("no attributes");
  for (const format::Attribute* attribute : *part.attributes()) {
    const auto semantic = static_cast<uint32_t>(attribute->semantic());
    if (semantic >= kSemantics || integers.attribute[semantic])
      return bad("an unknown or repeated attribute");
    const uint32_t most = componentsOf(attribute->semantic(), influences);
    const bool may_be_fewer = attribute->semantic() == format::Semantic::Joints ||
                              attribute->semantic() == format::Semantic::Weights;
    if (attribute->components() == 0 || attribute->components() > most ||
        (!may_be_fewer && attribute->components() != most))
      return bad("an attribute with the wrong number of components");
    if (attribute->bits() == 0 || attribute->bits() > 30)
      return bad("an attribute with the wrong number of bits");
    integers.attribute[semantic] = attribute;
  }
  for (const auto semantic : {format::Semantic::Position, format::Semantic::Normal, format::Semantic::Tangent,
                              format::Semantic::Joints, format::Semantic::Weights, format::Semantic::Source})
    if (!integers.attribute[static_cast<uint32_t>(semantic)]) return bad("an attribute is missing");
  if (integers.attribute[static_cast<uint32_t>(format::Semantic::Joints)]->components() !=
      integers.attribute[static_cast<uint32_t>(format::Semantic::Weights)]->components())
    return bad("joints and weights differ in number");
  return {};
}

Status readRaw(const format::Part& part, Integers& integers, std::vector<uint32_t>& indices) {
  for (uint32_t s = 0; s < kSemantics; ++s) {
    if (!integers.attribute[s]) continue;
    const size_t count = size_t{part.vertices()} * integers.attribute[s]->components();
    if (Status status = checkStream(integers.attribute[s]->stream(), 4, count); !status.ok()) return status;
    integers.values[s].resize(count);
    if (Status status = decodeStream(integers.attribute[s]->stream(), 4, count, integers.values[s].data());
        !status.ok())
      return status;
  }
  const size_t count = size_t{part.triangles()} * 3;
  if (Status status = checkStream(part.indices(), 4, count); !status.ok()) return status;
  indices.resize(count);
  return decodeStream(part.indices(), 4, count, indices.data());
}

#ifdef FURROW_WITH_DRACO
Status readDraco(const format::Part& part, Integers& integers, std::vector<uint32_t>& indices) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(part.draco()->data()), part.draco()->size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return bad("Draco cannot decode it");
  const draco::Mesh& mesh = *decoded.value();
  if (mesh.num_faces() != part.triangles()) return bad("Draco decodes another number of triangles");
  const draco::PointAttribute* attributes[kSemantics] = {};
  for (uint32_t s = 0; s < kSemantics; ++s) {
    if (!integers.attribute[s]) continue;
    attributes[s] = mesh.GetAttributeByUniqueId(static_cast<uint32_t>(s));
    if (!attributes[s] || attributes[s]->num_components() != integers.attribute[s]->components() ||
        attributes[s]->data_type() != draco::DT_UINT32)
      return bad("Draco lacks an attribute");
  }

  // Draco gives a vertex of a non-manifold edge several points, and none to one without a triangle.
  const auto* alone = integers.attribute[static_cast<uint32_t>(format::Semantic::Position)]->stream();
  if (part.vertices() > size_t{mesh.num_points()} + streamCount(alone) / 3)
    return bad("Draco decodes too few vertices");
  std::vector<uint32_t> vertex_of_source(part.vertices(), kAbsent), vertex_of_point, point_of_vertex;
  for (draco::PointIndex p(0); p < mesh.num_points(); ++p) {
    uint32_t source = 0;
    attributes[static_cast<uint32_t>(format::Semantic::Source)]->GetMappedValue(p, &source);
    if (source >= part.vertices()) return bad("a source vertex is out of range");
    if (vertex_of_source[source] == kAbsent) {
      vertex_of_source[source] = static_cast<uint32_t>(point_of_vertex.size());
      point_of_vertex.push_back(p.value());
    }
    vertex_of_point.push_back(vertex_of_source[source]);
  }
  const size_t without = part.vertices() - point_of_vertex.size();
  for (uint32_t s = 0; s < kSemantics; ++s) {
    if (!attributes[s]) continue;
    const uint32_t components = integers.attribute[s]->components();
    std::vector<uint32_t>& values = integers.values[s];
    values.resize(size_t{part.vertices()} * components);
    for (size_t v = 0; v < point_of_vertex.size(); ++v)
      attributes[s]->GetMappedValue(draco::PointIndex(point_of_vertex[v]), &values[v * components]);
    if (Status status = decodeStream(integers.attribute[s]->stream(), 4, without * components,
                                     values.data() + point_of_vertex.size() * components);
        !status.ok())
      return status;
  }
  indices.reserve(size_t{part.triangles()} * 3);
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
    for (uint32_t c = 0; c < 3; ++c) indices.push_back(vertex_of_point[mesh.face(f)[c].value()]);
  return {};
}
#endif

// value = offset + step * integer, component by component.
Status toFloats(const Integers& integers, format::Semantic semantic, uint32_t components, float* out,
                size_t vertices) {
  const auto s = static_cast<uint32_t>(semantic);
  const format::Attribute& attribute = *integers.attribute[s];
  if (!attribute.offset() || attribute.offset()->size() != components || !std::isfinite(attribute.step()))
    return bad("an attribute without offset or step");
  for (size_t v = 0; v < vertices; ++v)
    for (uint32_t c = 0; c < components; ++c) {
      const float value = attribute.offset()->Get(c) +
                          attribute.step() * static_cast<float>(integers.values[s][v * components + c]);
      if (!std::isfinite(value)) return bad("a number is not finite");
      out[v * components + c] = value;
    }
  return {};
}

float unorm(uint32_t value, uint32_t bits) {
  return static_cast<float>(value) / static_cast<float>((1u << bits) - 1);
}

}  // namespace

uint32_t streamCount(const format::Stream* stream) {
  return stream ? stream->count() : 0;
}

Status checkStream(const format::Stream* stream, uint32_t stride, size_t count) {
  if (count == 0) return {};
  if (!stream || !stream->data() || stream->stride() != stride || stream->count() != count)
    return bad("a stream has the wrong shape");
  if (count > kMostUnpacked * stream->data()->size() / stride) return bad("a stream is cut short");
  return {};
}

Status decodeStream(const format::Stream* stream, uint32_t stride, size_t count, void* out) {
  if (Status status = checkStream(stream, stride, count); count == 0 || !status.ok()) return status;
  const std::span<const uint8_t> bytes(stream->data()->data(), stream->data()->size());
  switch (stream->codec()) {
    case format::Codec::Raw:
      if (bytes.size() != count * stride) return bad("a stream is cut short");
      std::memcpy(out, bytes.data(), bytes.size());
      return {};
    case format::Codec::MeshoptVertex:
      if (!decodeVertexStream(bytes, count, stride, static_cast<uint8_t*>(out)))
        return bad("a vertex stream does not decode");
      return {};
    case format::Codec::MeshoptSequence:
      if (stride != 4 || !decodeIndexStream(bytes, count, static_cast<uint32_t*>(out)))
        return bad("an index stream does not decode");
      return {};
    case format::Codec::Entropy:
      if (!decodeEntropyStream(bytes, count, stride, static_cast<uint8_t*>(out)))
        return bad("an entropy-coded stream does not decode");
      return {};
  }
  return bad("a stream has an unknown codec");
}

Status decodePart(const format::Part& part, uint32_t influences, PartGeometry& out) {
  if (part.vertices() > kMaxVertices || part.triangles() > kMaxVertices)
    return bad("too many vertices or triangles");
  Integers integers;
  if (Status status = findAttributes(part, influences, integers); !status.ok()) return status;
  const size_t vertices = part.vertices();
  if (part.draco() && part.draco()->size() > 0) {
#ifdef FURROW_WITH_DRACO
    if (Status status = readDraco(part, integers, out.indices); !status.ok()) return status;
#else
    return Status::error(StatusCode::kUnsupportedFeature,
                         "its geometry is Draco-encoded, and this runtime was built without Draco");
#endif
  } else if (Status status = readRaw(part, integers, out.indices); !status.ok()) {
    return status;
  }
  for (uint32_t index : out.indices)
    if (index >= vertices) return bad("an index is out of range");

  const auto values = [&](format::Semantic semantic) -> const std::vector<uint32_t>& {
    return integers.values[static_cast<uint32_t>(semantic)];
  };
  const auto bits = [&](format::Semantic semantic) {
    return uint32_t{integers.attribute[static_cast<uint32_t>(semantic)]->bits()};
  };

  out.positions.resize(vertices);
  if (Status status = toFloats(integers, format::Semantic::Position, 3, &out.positions.data()->x, vertices);
      !status.ok())
    return status;
  const format::Attribute& position = *integers.attribute[static_cast<uint32_t>(format::Semantic::Position)];
  out.position_offset = {position.offset()->Get(0), position.offset()->Get(1), position.offset()->Get(2)};
  out.position_step = position.step();
  out.uvs.assign(vertices, {0.0f, 0.0f});
  if (integers.attribute[static_cast<uint32_t>(format::Semantic::Uv)])
    if (Status status = toFloats(integers, format::Semantic::Uv, 2, &out.uvs.data()->x, vertices);
        !status.ok())
      return status;

  out.normals.resize(vertices);
  out.tangents.resize(vertices);
  for (size_t v = 0; v < vertices; ++v) {
    const std::vector<uint32_t>& normal = values(format::Semantic::Normal);
    out.normals[v] = decodeOctahedral(normal[2 * v], normal[2 * v + 1], bits(format::Semantic::Normal));
    out.tangents[v] =
        decodeTangent(out.normals[v], values(format::Semantic::Tangent)[v], bits(format::Semantic::Tangent));
  }

  const uint32_t stored = integers.attribute[static_cast<uint32_t>(format::Semantic::Joints)]->components();
  out.joints.assign(vertices * influences, 0);
  out.weights.assign(vertices * influences, 0);
  for (size_t v = 0; v < vertices; ++v) {
    uint32_t sum = 0;
    for (uint32_t k = 0; k < stored; ++k) {
      const uint32_t joint = values(format::Semantic::Joints)[v * stored + k];
      const uint32_t weight = values(format::Semantic::Weights)[v * stored + k];
      if (joint >= part.palette_count() || weight > 65535) return bad("a joint or weight is out of range");
      out.joints[v * influences + k] = static_cast<uint16_t>(joint);
      out.weights[v * influences + k] = static_cast<uint16_t>(weight);
      sum += weight;
    }
    if (sum != 65535) return bad("weights do not sum to one");
  }

  out.source = values(format::Semantic::Source);
  std::vector<bool> seen(vertices);
  for (uint32_t source : out.source) {
    if (source >= vertices || seen[source]) return bad("source vertices are no permutation");
    seen[source] = true;
  }
  return {};
}

Float3 decodeOctahedral(uint32_t u, uint32_t v, uint32_t bits) {
  float x = unorm(u, bits) * 2.0f - 1.0f;
  float y = unorm(v, bits) * 2.0f - 1.0f;
  const float z = 1.0f - std::abs(x) - std::abs(y);
  const float fold = std::max(-z, 0.0f);
  x += x >= 0.0f ? -fold : fold;
  y += y >= 0.0f ? -fold : fold;
  const float length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

void encodeOctahedral(Float3 n, uint32_t bits, uint32_t& u, uint32_t& v) {
  const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
  float x = n.x / sum;
  float y = n.y / sum;
  if (n.z < 0.0f) {
    const float folded = (1.0f - std::abs(y)) * (x >= 0.0f ? 1.0f : -1.0f);
    y = (1.0f - std::abs(x)) * (y >= 0.0f ? 1.0f : -1.0f);
    x = folded;
  }
  const float most = static_cast<float>((1u << bits) - 1);
  u = static_cast<uint32_t>(std::lround((x * 0.5f + 0.5f) * most));
  v = static_cast<uint32_t>(std::lround((y * 0.5f + 0.5f) * most));
}

void tangentBasis(Float3 n, Float3& t, Float3& b) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float xy = n.x * n.y * a;
  t = {1.0f + sign * n.x * n.x * a, sign * xy, -sign * n.x};
  b = {xy, sign + n.y * n.y * a, -n.y};
}

Float4 decodeTangent(Float3 normal, uint32_t code, uint32_t bits) {
  Float3 t, b;
  tangentBasis(normal, t, b);
  const float steps = static_cast<float>(1u << (bits - 1));
  const float angle = static_cast<float>(code >> 1) / steps * 2.0f * std::numbers::pi_v<float>;
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  return {c * t.x + s * b.x, c * t.y + s * b.y, c * t.z + s * b.z, (code & 1) ? -1.0f : 1.0f};
}

uint32_t encodeTangent(Float3 normal, Float4 tangent, uint32_t bits) {
  Float3 t, b;
  tangentBasis(normal, t, b);
  const float x = tangent.x * t.x + tangent.y * t.y + tangent.z * t.z;
  const float y = tangent.x * b.x + tangent.y * b.y + tangent.z * b.z;
  const int64_t steps = int64_t{1} << (bits - 1);
  const float turn = std::atan2(y, x) / (2.0f * std::numbers::pi_v<float>);
  const int64_t step = (std::llround(turn * static_cast<float>(steps)) + steps) % steps;
  return static_cast<uint32_t>(step) << 1 | (tangent.w < 0.0f ? 1u : 0u);
}

}  // namespace furrow
