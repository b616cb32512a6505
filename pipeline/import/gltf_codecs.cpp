#include "pipeline/import/gltf_codecs.h"

#include <draco/compression/decode.h>
#include <meshoptimizer.h>

#include <cstring>
#include <memory>
#include <stdexcept>

namespace furrow::pipeline {
namespace {

// meshoptimizer's vertex codec spends at least 2 bits a header group of 16 values, its index codecs a byte a
// triangle (12 bytes decoded).
constexpr size_t kHighestMeshoptRatio = 64;

int componentType(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 5120;
    case draco::DT_UINT8:
      return 5121;
    case draco::DT_INT16:
      return 5122;
    case draco::DT_UINT16:
      return 5123;
    case draco::DT_UINT32:
      return 5125;
    case draco::DT_FLOAT32:
      return 5126;
    default:
      throw std::runtime_error("a Draco attribute has a component type that glTF does not know");
  }
}

DracoAttribute unpack(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  DracoAttribute out;
  out.component_type = componentType(attribute.data_type());
  out.components = attribute.num_components();
  const size_t element =
      static_cast<size_t>(draco::DataTypeLength(attribute.data_type())) * attribute.num_components();
  const draco::DataBuffer* buffer = attribute.buffer();
  if (!buffer || out.components == 0 || out.components > 4 || attribute.byte_offset() < 0 ||
      attribute.byte_stride() < static_cast<int64_t>(element))
    throw std::runtime_error("a Draco attribute is damaged");
  out.bytes.resize(element * mesh.num_points());
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute.size() ||
        static_cast<size_t>(attribute.GetBytePos(value)) + element > buffer->data_size())
      throw std::runtime_error("a Draco attribute is damaged");
    std::memcpy(out.bytes.data() + element * i, buffer->data() + attribute.GetBytePos(value), element);
  }
  return out;
}

}  // namespace

DracoMesh decodeDraco(std::span<const uint8_t> bytes, const std::map<std::string, int>& ids) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    throw std::runtime_error("Draco cannot decode it: " + decoded.status().error_msg_string());
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();

  DracoMesh out;
  out.vertices = mesh->num_points();
  out.indices.reserve(3 * static_cast<size_t>(mesh->num_faces()));
  for (uint32_t f = 0; f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(f))) {
      if (corner.value() >= out.vertices)
        throw std::runtime_error("a Draco face has a corner that does not exist");
      out.indices.push_back(corner.value());
    }
  }
  for (const auto& [name, id] : ids) {
    const draco::PointAttribute* attribute =
        id < 0 ? nullptr : mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id));
    if (!attribute)
      throw std::runtime_error("its Draco mesh has no attribute " + std::to_string(id) + " (" + name + ")");
    out.attributes.emplace(name, unpack(*mesh, *attribute));
  }
  return out;
}

std::vector<uint8_t> decodeMeshopt(std::span<const uint8_t> bytes, size_t count, size_t stride,
                                   const std::string& mode, const std::string& filter) {
  const bool attributes = mode == "ATTRIBUTES";
  const bool triangles = mode == "TRIANGLES";
  if (!attributes && !triangles && mode != "INDICES")
    throw std::runtime_error("meshopt compression mode \"" + mode + "\" is unknown");
  if (attributes ? stride == 0 || stride > 256 || stride % 4 != 0 : stride != 2 && stride != 4)
    throw std::runtime_error("meshopt-compressed data has the impossible stride " + std::to_string(stride));
  if (triangles && count % 3 != 0)
    throw std::runtime_error("meshopt-compressed triangles do not come in threes");
  if (count > kHighestMeshoptRatio * bytes.size() / stride)
    throw std::runtime_error("meshopt-compressed data promises more than its bytes can hold");

  std::vector<uint8_t> out(count * stride);
  const int failed =
      attributes  ? meshopt_decodeVertexBuffer(out.data(), count, stride, bytes.data(), bytes.size())
      : triangles ? meshopt_decodeIndexBuffer(out.data(), count, stride, bytes.data(), bytes.size())
                  : meshopt_decodeIndexSequence(out.data(), count, stride, bytes.data(), bytes.size());
  if (failed) throw std::runtime_error("meshopt-compressed data is damaged");

  if (filter == "OCTAHEDRAL" && attributes && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(out.data(), count, stride);
  } else if (filter == "QUATERNION" && attributes && stride == 8) {
    meshopt_decodeFilterQuat(out.data(), count, stride);
  } else if (filter == "EXPONENTIAL" && attributes) {
    meshopt_decodeFilterExp(out.data(), count, stride);
  } else if (filter != "NONE") {
    throw std::runtime_error("meshopt filter \"" + filter + "\" does not fit the data");
  }
  return out;
}

}  // namespace furrow::pipeline
