#pragma once

// A glTF file whose every reference into bytes is checked before it is followed: container, JSON (read by
// tinygltf), buffers, accessors, Draco and meshopt compression. What is wrong with the file throws Error or
// std::runtime_error.

// Images are not decoded; the class differs with these, so that nothing else may include the header.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/import/gltf_codecs.h"

namespace furrow::pipeline {

// Where older exporters (Sketchfab's above all) have a material's colours.
inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

// An accessor in place. All its elements and sparse replacements lie inside bytes that outlive it (the
// document's).
struct AccessorView {
  size_t count = 0;
  int component_type = 0;  // glTF's number
  uint32_t components = 0;
  bool normalized = false;
  size_t stride = 0;
  const uint8_t* bytes = nullptr;  // null: zeros
  size_t sparse_count = 0;
  int sparse_index_type = 0;
  const uint8_t* sparse_indices = nullptr;
  const uint8_t* sparse_values = nullptr;

  bool isFloat() const;
};

// All elements as floats, `components` an element. Integers are scaled to [0, 1] or [-1, 1] if `normalized`.
void readFloats(const AccessorView& view, bool normalized, std::span<float> out);

// All elements of an accessor of unsigned integers.
std::vector<uint32_t> readUnsigned(const AccessorView& view);

struct SourceImage;

class GltfDocument {
 public:
  GltfDocument(const std::filesystem::path& file, std::vector<uint8_t> bytes);

  // Without images, textures, samplers, cameras and buffers. Primitives with Draco compression have no
  // indices here.
  const tinygltf::Model& model() const { return model_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  const std::vector<std::filesystem::path>& dependencies() const { return dependencies_; }
  bool uses(const std::string& extension) const;

  AccessorView accessor(int index);

  // The number of the image that a texture shows as PNG, JPEG or WebP; throws if there is none.
  int imageOfTexture(int texture) const;
  std::array<Wrap, 2> wrapOfTexture(int texture) const;
  // The image, as encoded.
  SourceImage image(int number);
  std::vector<std::string> imageNames() const;

  // The primitive's Draco mesh, decoded; null if it has none.
  std::unique_ptr<const DracoMesh> draco(const tinygltf::Primitive& primitive);

 private:
  struct Image {
    int view = -1;
    std::string name, uri;
  };
  struct Buffer {
    std::vector<uint8_t> owned;
    std::span<const uint8_t> bytes;
  };

  void readImages(const nlohmann::json& root);
  std::span<const uint8_t> bufferBytes(int buffer, size_t offset, size_t length, const std::string& of) const;
  std::span<const uint8_t> viewBytes(int view);

  std::filesystem::path file_;
  std::vector<uint8_t> bytes_;
  std::vector<Buffer> buffers_;
  std::vector<Image> images_;
  struct Texture {
    int image = -1;  // number; -1: none that is read
    std::array<Wrap, 2> wrap{};
  };
  std::vector<Texture> textures_;
  size_t total_bytes_ = 0;
  size_t numbers_ = 0;  // in all accessors that were asked for
  tinygltf::Model model_;
  std::map<int, std::vector<uint8_t>> decoded_views_;
  std::vector<std::string> warnings_;
  std::vector<std::filesystem::path> dependencies_;
};

}  // namespace furrow::pipeline
