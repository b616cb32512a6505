#include "pipeline/import/gltf_document.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/input_file.h"
#include "pipeline/one_line.h"

namespace furrow::pipeline {
namespace {

using nlohmann::json;
using Bytes = std::span<const uint8_t>;

// tinygltf walks `extras` and `extensions` by recursion.
constexpr int kDeepestNesting = 100;
constexpr uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

// Accessors may be read any number of times, and may hold more zeros than the file has bytes.
constexpr size_t kNumbersAtLeast = size_t{1} << 26, kNumbersPerByte = 64;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kQuantization = "KHR_mesh_quantization";
constexpr const char* kWebp = "EXT_texture_webp";
constexpr const char* kTextureTransform = "KHR_texture_transform";

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

uint32_t readU32(Bytes bytes, size_t offset) {
  uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

struct Container {
  Bytes json;
  Bytes bin;
};

Container openGlb(Bytes file) {
  if (file.size() < 20) fail("the GLB header is cut off");
  if (readU32(file, 4) != 2)
    fail("GLB version " + std::to_string(readU32(file, 4)) + "; furrow reads version 2");
  const size_t length = readU32(file, 8);
  if (length > file.size())
    fail("cut off: " + std::to_string(file.size()) + " bytes of " + std::to_string(length));
  Container out;
  for (size_t at = 12; at + 8 <= length;) {
    const size_t size = readU32(file, at);
    const uint32_t type = readU32(file, at + 4);
    if (size > length - at - 8) fail("a GLB chunk ends behind the end of the file");
    const Bytes chunk = file.subspan(at + 8, size);
    if (at == 12) {
      if (type != kJsonChunk) fail("the first GLB chunk is not JSON");
      out.json = chunk;
    } else if (type == kBinChunk && out.bin.empty()) {
      out.bin = chunk;
    }
    at += 8 + (size + 3) / 4 * 4;
  }
  while (!out.json.empty() && out.json.back() == 0) out.json = out.json.first(out.json.size() - 1);
  if (out.json.empty()) fail("the GLB has no JSON");
  return out;
}

bool isGlb(Bytes file) {
  return file.size() >= 4 && readU32(file, 0) == kGlbMagic;
}

// Integers that fit no 32-bit type become floating-point, so that nobody downstream truncates them into a
// valid index.
json parseJson(Bytes text) {
  const auto guard = [](int depth, json::parse_event_t event, json& value) {
    if (depth > kDeepestNesting) fail("its JSON is nested too deeply");
    if (event == json::parse_event_t::value && value.is_number_integer()) {
      const bool fits = value.is_number_unsigned()
                            ? value.get<uint64_t>() <= std::numeric_limits<uint32_t>::max()
                            : value.get<int64_t>() >= std::numeric_limits<int32_t>::min();
      if (!fits) value = value.get<double>();
    }
    return true;
  };
  try {
    json root = json::parse(text.begin(), text.end(), guard);
    if (!root.is_object()) fail("not glTF (its JSON is not an object)");
    return root;
  } catch (const json::exception& e) {
    fail(std::string("its JSON is damaged: ") + e.what());
  }
}

void checkAsset(const json& root) {
  const auto asset = root.find("asset");
  if (asset == root.end() || !asset->is_object()) fail("not glTF (no \"asset\" in its JSON)");
  const auto version = asset->find("version");
  if (version == asset->end() || !version->is_string()) fail("not glTF (no \"asset.version\" in its JSON)");
  const auto minimum = asset->find("minVersion");
  const std::string needed = minimum != asset->end() && minimum->is_string() ? minimum->get<std::string>()
                                                                             : version->get<std::string>();
  const bool readable = minimum == asset->end() ? needed.starts_with("2.") : needed == "2.0";
  if (!readable) fail("glTF version \"" + needed + "\"; furrow reads 2.0");
}

std::vector<std::string> checkExtensions(const json& root) {
  std::vector<std::string> warnings;
  const auto required = root.find("extensionsRequired");
  if (required == root.end()) return warnings;
  if (!required->is_array()) fail("\"extensionsRequired\" is not an array");
  for (const json& entry : *required) {
    if (!entry.is_string()) fail("\"extensionsRequired\" holds something that is not a name");
    const std::string name = entry.get<std::string>();
    if (name == kDraco || name == kMeshopt || name == kQuantization || name == kWebp ||
        name == kTextureTransform)
      continue;
    const auto about = [&](const char* word) { return name.find(word) != std::string::npos; };
    if (about("_materials_") || about("_lights_") || about("_xmp") || about("_node_") || about("VRM") ||
        name == "KHR_animation_pointer" || name == "FB_ngon_encoding" || name == "MSFT_lod") {
      warnings.push_back("the required extension " + name + " is left out: it does not shape the surface");
    } else {
      fail("it requires the extension " + name + ", which furrow does not read");
    }
  }
  return warnings;
}

const json* find(const json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

// Element `index` of an array of the root; null where either is not sound.
const json* element(const json& root, const char* array, const json* index) {
  const json* list = find(root, array);
  if (!list || !list->is_array() || !index || !index->is_number_unsigned()) return nullptr;
  const auto i = index->get<size_t>();
  return i < list->size() ? &(*list)[i] : nullptr;
}

// The number of a texture's image; null if it has none of a format that is read.
const json* imageOf(const json& texture) {
  if (const json* source = find(texture, "source")) return source;
  const json* extensions = find(texture, "extensions");
  const json* webp = extensions ? find(*extensions, kWebp) : nullptr;
  return webp ? find(*webp, "source") : nullptr;
}

// tinygltf leaves out primitives that it cannot read without a word, and refuses indices that have no buffer
// view, as Draco's have not.
void checkPrimitives(json& root) {
  const auto meshes = root.find("meshes");
  if (meshes == root.end()) return;
  if (!meshes->is_array()) fail("\"meshes\" is not an array");
  for (json& mesh : *meshes) {
    const auto primitives = mesh.is_object() ? mesh.find("primitives") : mesh.end();
    if (primitives == mesh.end() || !primitives->is_array()) fail("a mesh has no array of primitives");
    for (json& primitive : *primitives) {
      const json* attributes = primitive.is_object() ? find(primitive, "attributes") : nullptr;
      if (!attributes || !attributes->is_object()) fail("a primitive has no attributes");
      for (const json& accessor : *attributes)
        if (!accessor.is_number_integer()) fail("a primitive's attribute is not the number of an accessor");
      const json* extensions = find(primitive, "extensions");
      if (extensions && extensions->is_object() && extensions->contains(kDraco)) primitive.erase("indices");
    }
  }
}

// Animation channels that name no node, which tinygltf leaves out without a word.
size_t pointersIn(const json& root) {
  size_t count = 0;
  const auto each = [](const json* list, const auto& visit) {
    if (list && list->is_array()) std::for_each(list->begin(), list->end(), visit);
  };
  each(find(root, "animations"), [&](const json& animation) {
    each(find(animation, "channels"), [&](const json& channel) {
      const json* target = find(channel, "target");
      count += target && target->is_object() && !target->contains("node");
    });
  });
  return count;
}

// Everything that furrow does not need of a file is dropped before it can do harm.
void dropUnused(json& root) {
  for (const char* key : {"buffers", "images", "textures", "samplers", "cameras", "extensions", "extras"})
    root.erase(key);
}

// tinygltf takes an index or a count that is no whole number for one that is left out. `key`: of what holds
// the value.
void checkWholeNumbers(const json& value, std::string_view key) {
  static constexpr std::string_view kWhole[] = {"buffer",
                                                "bufferView",
                                                "byteLength",
                                                "byteOffset",
                                                "byteStride",
                                                "children",
                                                "componentType",
                                                "count",
                                                "indices",
                                                "input",
                                                "inverseBindMatrices",
                                                "joints",
                                                "material",
                                                "mesh",
                                                "mode",
                                                "node",
                                                "nodes",
                                                "output",
                                                "sampler",
                                                "scene",
                                                "skin"};
  if (value.is_object()) {
    for (const auto& [name, member] : value.items())
      if (name != "extras" && name != "extensions") checkWholeNumbers(member, name);
  } else if (value.is_array()) {
    for (const json& element : value) checkWholeNumbers(element, key);
  } else if (!value.is_number_integer() && std::ranges::find(kWhole, key) != std::end(kWhole)) {
    fail("\"" + std::string(key) + "\" is " +
         value.dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 40) +
         " and no whole number of at most 32 bits");
  }
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string decodePercent(std::string_view uri) {
  std::string out;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hexDigit(uri[i + 1]) >= 0 && hexDigit(uri[i + 2]) >= 0) {
      out.push_back(static_cast<char>(16 * hexDigit(uri[i + 1]) + hexDigit(uri[i + 2])));
      i += 2;
    } else {
      out.push_back(uri[i]);
    }
  }
  return out;
}

bool isData(const std::string& uri) {
  return uri.starts_with("data:");
}

std::filesystem::path fileOf(const std::filesystem::path& file, const std::string& uri) {
  const std::string name = decodePercent(uri);
  if (name.empty() || name.find('\0') != std::string::npos) fail("a URI in it names no file");
  return namedFile(name, file.parent_path());
}

std::vector<uint8_t> decodeDataUri(const std::string& uri) {
  constexpr std::string_view kBase64 = ";base64,";
  const size_t header = uri.find(kBase64);
  if (header == std::string::npos || uri.find(',') < header) fail("a data URI in it is not in base64");
  std::vector<uint8_t> bytes;
  std::string mime_type;
  tinygltf::DecodeDataURI(&bytes, mime_type,
                          "data:application/octet-stream;base64," + uri.substr(header + kBase64.size()), 0,
                          false);
  return bytes;
}

size_t componentSize(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      fail("an accessor has the unknown component type " + std::to_string(type));
  }
}

template <typename Visitor>
void withComponentType(int type, Visitor&& visit) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return visit(int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return visit(uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return visit(int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return visit(uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return visit(uint32_t{});
    default:
      return visit(float{});
  }
}

template <typename T>
T load(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <typename T>
float toFloat(T value, bool normalized) {
  if constexpr (std::is_same_v<T, float>) {
    return value;
  } else {
    if (!normalized) return static_cast<float>(value);
    constexpr double kLargest = static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<float>(std::max(static_cast<double>(value) / kLargest, -1.0));
  }
}

uint32_t sparseIndex(const AccessorView& view, size_t i) {
  uint32_t index = 0;
  withComponentType(view.sparse_index_type, [&](auto type) {
    using T = decltype(type);
    if constexpr (std::is_unsigned_v<T>) index = load<T>(view.sparse_indices + i * sizeof(T));
  });
  if (index >= view.count) fail("a sparse accessor replaces an element that it does not have");
  return index;
}

// element(i, bytes) for every element, the sparse ones once more behind.
template <typename T, typename Element>
void forEachElement(const AccessorView& view, Element&& element) {
  if (view.bytes)
    for (size_t i = 0; i < view.count; ++i) element(i, view.bytes + i * view.stride);
  for (size_t i = 0; i < view.sparse_count; ++i)
    element(sparseIndex(view, i), view.sparse_values + i * view.components * sizeof(T));
}

size_t unsignedMember(const tinygltf::Value& object, const char* key, std::optional<size_t> otherwise = {}) {
  const tinygltf::Value& value = object.Get(key);
  if (value.IsInt() && value.GetNumberAsInt() >= 0) return static_cast<size_t>(value.GetNumberAsInt());
  if (otherwise && value.Type() == tinygltf::NULL_TYPE) return *otherwise;
  fail(std::string("\"") + key + "\" of a compression extension is missing or no count");
}

std::string stringMember(const tinygltf::Value& object, const char* key, const char* otherwise) {
  const tinygltf::Value& value = object.Get(key);
  return value.IsString() ? value.Get<std::string>() : otherwise;
}

}  // namespace

bool AccessorView::isFloat() const {
  return component_type == TINYGLTF_COMPONENT_TYPE_FLOAT;
}

void readFloats(const AccessorView& view, bool normalized, std::span<float> out) {
  if (!view.bytes) std::fill(out.begin(), out.end(), 0.0f);
  withComponentType(view.component_type, [&](auto type) {
    using T = decltype(type);
    forEachElement<T>(view, [&](size_t i, const uint8_t* bytes) {
      for (size_t c = 0; c < view.components; ++c)
        out[i * view.components + c] = toFloat(load<T>(bytes + c * sizeof(T)), normalized);
    });
  });
}

std::vector<uint32_t> readUnsigned(const AccessorView& view) {
  std::vector<uint32_t> out(view.count * view.components);
  withComponentType(view.component_type, [&](auto type) {
    using T = decltype(type);
    if constexpr (std::is_unsigned_v<T>) {
      forEachElement<T>(view, [&](size_t i, const uint8_t* bytes) {
        for (size_t c = 0; c < view.components; ++c)
          out[i * view.components + c] = load<T>(bytes + c * sizeof(T));
      });
    } else {
      fail("indices or joints are not unsigned integers");
    }
  });
  return out;
}

GltfDocument::GltfDocument(const std::filesystem::path& file, std::vector<uint8_t> bytes)
    : file_(file), bytes_(std::move(bytes)), total_bytes_(bytes_.size()), dependencies_{file} {
  const bool glb = isGlb(bytes_);
  const Container container = glb ? openGlb(bytes_) : Container{bytes_, {}};
  json root = parseJson(container.json);
  checkAsset(root);
  warnings_ = checkExtensions(root);
  checkPrimitives(root);

  const json* buffers = find(root, "buffers");
  if (buffers && !buffers->is_array()) fail("\"buffers\" is not an array");
  for (size_t b = 0; buffers && b < buffers->size(); ++b) {
    const json& entry = (*buffers)[b];
    const std::string name = "buffer " + std::to_string(b);
    const json* length = entry.is_object() ? find(entry, "byteLength") : nullptr;
    if (!length || !length->is_number_unsigned()) fail(name + " has no byteLength");
    const json* uri = find(entry, "uri");
    Buffer buffer;
    if (!uri) {
      // Without a URI: the GLB's own chunk, or a stand-in for compressed data that holds nothing.
      if (glb && b == 0) buffer.bytes = container.bin;
    } else if (!uri->is_string()) {
      fail(name + " has a URI that is no string");
    } else if (const std::string& text = uri->get_ref<const std::string&>(); isData(text)) {
      buffer.owned = decodeDataUri(text);
    } else {
      const std::filesystem::path path = fileOf(file_, text);
      if (!std::filesystem::is_regular_file(path))
        throw Error(Exit::kBadData, file_.string(),
                    "it needs the file " + path.string() + ", which is not there",
                    "put it there or embed it");
      buffer.owned = readBytes(path);
      if (std::find(dependencies_.begin(), dependencies_.end(), path) == dependencies_.end())
        dependencies_.push_back(path);
    }
    if (uri) {
      buffer.bytes = buffer.owned;
      total_bytes_ += buffer.owned.size();
    }
    const size_t promised = length->get<size_t>();
    if ((uri || !buffer.bytes.empty()) && buffer.bytes.size() < promised)
      fail(name + " is cut off: " + std::to_string(buffer.bytes.size()) + " bytes of " +
           std::to_string(promised));
    buffer.bytes = buffer.bytes.first(std::min(buffer.bytes.size(), promised));
    buffers_.push_back(std::move(buffer));
  }

  readImages(root);
  if (const size_t count = pointersIn(root))
    warnings_.push_back(std::to_string(count) +
                        " animation channels are left out: they move something other than a node "
                        "(KHR_animation_pointer), which furrow does not read");
  dropUnused(root);
  checkWholeNumbers(root, "");
  const std::string text = root.dump();
  root = nullptr;
  if (text.size() > std::numeric_limits<uint32_t>::max()) fail("its JSON is too long");
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  if (!loader.LoadASCIIFromString(&model_, &error, &warning, text.data(), static_cast<uint32_t>(text.size()),
                                  ""))
    fail(error.empty() ? "tinygltf cannot read it" : error);
  const auto clean = [](auto& items) {
    for (auto& item : items) item.name = oneLine(std::move(item.name));
  };
  clean(model_.nodes);
  clean(model_.meshes);
  clean(model_.materials);
  clean(model_.skins);
  clean(model_.animations);
}

std::vector<std::filesystem::path> gltfFiles(const std::filesystem::path& file,
                                             const std::vector<uint8_t>& bytes) {
  const json root = parseJson(isGlb(bytes) ? openGlb(bytes).json : bytes);
  std::vector<std::filesystem::path> files;
  const auto add = [&](const json* entry, bool needed) {
    const json* uri = entry ? find(*entry, "uri") : nullptr;
    if (!uri || !uri->is_string() || isData(uri->get_ref<const std::string&>())) return;
    std::filesystem::path path = fileOf(file, uri->get_ref<const std::string&>());
    if (std::ranges::find(files, path) == files.end() && (needed || std::filesystem::is_regular_file(path)))
      files.push_back(std::move(path));
  };
  const auto each = [&](const char* array, const auto& visit) {
    const json* list = find(root, array);
    if (list && list->is_array()) std::for_each(list->begin(), list->end(), visit);
  };
  each("buffers", [&](const json& buffer) { add(&buffer, true); });
  each("materials", [&](const json& material) {
    const json* extensions = find(material, "extensions");
    const json* glossy = extensions ? find(*extensions, kSpecularGlossiness) : nullptr;
    const json* colors = glossy ? glossy : find(material, "pbrMetallicRoughness");
    for (const json* info : {colors ? find(*colors, glossy ? "diffuseTexture" : "baseColorTexture") : nullptr,
                             find(material, "normalTexture")}) {
      const json* texture = info ? element(root, "textures", find(*info, "index")) : nullptr;
      if (texture) add(element(root, "images", imageOf(*texture)), false);
    }
  });
  return files;
}

void GltfDocument::readImages(const json& root) {
  const json* images = find(root, "images");
  for (size_t i = 0; images && images->is_array() && i < images->size(); ++i) {
    const json& entry = (*images)[i];
    Image& image = images_.emplace_back();
    const auto text = [&](const char* key) {
      const json* value = find(entry, key);
      return value && value->is_string() ? value->get<std::string>() : std::string();
    };
    image.name = text("name");
    image.uri = text("uri");
    if (const json* view = find(entry, "bufferView"); view && view->is_number_unsigned())
      image.view = view->get<int>();
  }
  const json* textures = find(root, "textures");
  for (size_t t = 0; textures && textures->is_array() && t < textures->size(); ++t) {
    const json* number = imageOf((*textures)[t]);
    Texture& texture = textures_.emplace_back();
    if (element(root, "images", number)) texture.image = number->get<int>();
    const json* sampler = element(root, "samplers", find((*textures)[t], "sampler"));
    for (const auto& [key, wrap] : {std::pair("wrapS", &texture.wrap[0]), {"wrapT", &texture.wrap[1]}}) {
      const json* way = sampler ? find(*sampler, key) : nullptr;
      if (way && *way == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) *wrap = Wrap::kClamp;
      if (way && *way == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) *wrap = Wrap::kMirror;
    }
  }
}

int GltfDocument::imageOfTexture(int texture) const {
  if (texture < 0 || static_cast<size_t>(texture) >= textures_.size())
    fail("there is no texture " + std::to_string(texture));
  const int number = textures_[static_cast<size_t>(texture)].image;
  if (number < 0) fail("it has no PNG, JPEG or WebP image");
  return number;
}

std::array<Wrap, 2> GltfDocument::wrapOfTexture(int texture) const {
  return textures_.at(static_cast<size_t>(texture)).wrap;
}

SourceImage GltfDocument::image(int number) {
  const Image& image = images_.at(static_cast<size_t>(number));
  SourceImage out;
  out.name = "image " + std::to_string(number);
  if (!image.name.empty()) out.name += " \"" + image.name + "\"";
  if (isData(image.uri)) {
    out.bytes = decodeDataUri(image.uri);
  } else if (!image.uri.empty()) {
    out.file = fileOf(file_, image.uri);
  } else {
    const Bytes bytes = viewBytes(image.view);
    out.bytes.assign(bytes.begin(), bytes.end());
  }
  return out;
}

std::vector<std::string> GltfDocument::imageNames() const {
  std::vector<std::string> names;
  for (const Image& image : images_) names.push_back(oneLine(image.name));
  return names;
}

bool GltfDocument::uses(const std::string& extension) const {
  const auto in = [&](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), extension) != list.end();
  };
  return in(model_.extensionsUsed) || in(model_.extensionsRequired);
}

std::span<const uint8_t> GltfDocument::bufferBytes(int buffer, size_t offset, size_t length,
                                                   const std::string& of) const {
  if (buffer < 0 || static_cast<size_t>(buffer) >= buffers_.size())
    fail(of + " lies in buffer " + std::to_string(buffer) + ", which does not exist");
  const Bytes bytes = buffers_[static_cast<size_t>(buffer)].bytes;
  if (offset > bytes.size() || length > bytes.size() - offset)
    fail(of + " reaches behind the end of buffer " + std::to_string(buffer));
  return bytes.subspan(offset, length);
}

std::span<const uint8_t> GltfDocument::viewBytes(int index) {
  const std::string name = "buffer view " + std::to_string(index);
  if (index < 0 || static_cast<size_t>(index) >= model_.bufferViews.size()) fail(name + " does not exist");
  const tinygltf::BufferView& view = model_.bufferViews[static_cast<size_t>(index)];
  const auto compressed = view.extensions.find(kMeshopt);
  if (compressed == view.extensions.end())
    return bufferBytes(view.buffer, view.byteOffset, view.byteLength, name);

  const auto decoded = decoded_views_.find(index);
  if (decoded != decoded_views_.end()) return decoded->second;
  const tinygltf::Value& extension = compressed->second;
  const size_t count = unsignedMember(extension, "count");
  const size_t stride = unsignedMember(extension, "byteStride");
  const Bytes bytes =
      bufferBytes(extension.Get("buffer").GetNumberAsInt(), unsignedMember(extension, "byteOffset", 0),
                  unsignedMember(extension, "byteLength"), name);
  if (count * stride != view.byteLength) fail(name + " and its meshopt compression differ in length");
  return decoded_views_
      .emplace(index, decodeMeshopt(bytes, count, stride, stringMember(extension, "mode", ""),
                                    stringMember(extension, "filter", "NONE")))
      .first->second;
}

AccessorView GltfDocument::accessor(int index) {
  const std::string name = "accessor " + std::to_string(index);
  if (index < 0 || static_cast<size_t>(index) >= model_.accessors.size()) fail(name + " does not exist");
  const tinygltf::Accessor& accessor = model_.accessors[static_cast<size_t>(index)];
  AccessorView view;
  view.count = accessor.count;
  view.component_type = accessor.componentType;
  view.normalized = accessor.normalized;
  view.components =
      static_cast<uint32_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)));
  const size_t element = componentSize(accessor.componentType) * view.components;
  if (view.count == 0) fail(name + " is empty");
  if (view.count > std::numeric_limits<uint32_t>::max()) fail(name + " is too long");

  if (accessor.bufferView >= 0) {
    const Bytes bytes = viewBytes(accessor.bufferView);
    const size_t stride = model_.bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
    view.stride = stride ? stride : element;
    if (view.stride < element) fail(name + " has elements longer than the stride of its buffer view");
    if (accessor.byteOffset > bytes.size() || element > bytes.size() - accessor.byteOffset ||
        view.count - 1 > (bytes.size() - accessor.byteOffset - element) / view.stride)
      fail(name + " reaches behind the end of its buffer view");
    view.bytes = bytes.data() + accessor.byteOffset;
  } else if (view.count > total_bytes_) {
    fail(name + " has more elements than the file has bytes");
  }
  numbers_ += view.count * view.components;
  if (numbers_ > kNumbersAtLeast + kNumbersPerByte * total_bytes_)
    fail("it uses its data over and over, into more than furrow reads");

  if (accessor.sparse.isSparse) {
    const auto& sparse = accessor.sparse;
    if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
      fail(name + " has a negative sparse count or offset");
    view.sparse_count = static_cast<size_t>(sparse.count);
    view.sparse_index_type = sparse.indices.componentType;
    if (view.sparse_index_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
        view.sparse_index_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        view.sparse_index_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
      fail(name + " has sparse indices that are not unsigned integers");
    const auto inside = [&](int buffer_view, int offset, size_t size) {
      const Bytes bytes = viewBytes(buffer_view);
      const size_t begin = static_cast<size_t>(offset);
      if (begin > bytes.size() || view.sparse_count > (bytes.size() - begin) / size)
        fail(name + " has sparse data that reaches behind the end of its buffer view");
      return bytes.data() + begin;
    };
    view.sparse_indices =
        inside(sparse.indices.bufferView, sparse.indices.byteOffset, componentSize(view.sparse_index_type));
    view.sparse_values = inside(sparse.values.bufferView, sparse.values.byteOffset, element);
  }
  return view;
}

std::unique_ptr<const DracoMesh> GltfDocument::draco(const tinygltf::Primitive& primitive) {
  const auto compressed = primitive.extensions.find(kDraco);
  if (compressed == primitive.extensions.end()) return nullptr;
  const tinygltf::Value& extension = compressed->second;
  std::map<std::string, int> ids;
  const tinygltf::Value& attributes = extension.Get("attributes");
  if (attributes.IsObject())
    for (const auto& [name, id] : attributes.Get<tinygltf::Value::Object>())
      if (primitive.attributes.contains(name)) ids.emplace(name, id.IsInt() ? id.Get<int>() : -1);
  const tinygltf::Value& view = extension.Get("bufferView");
  return std::make_unique<const DracoMesh>(decodeDraco(viewBytes(view.IsInt() ? view.Get<int>() : -1), ids));
}

}  // namespace furrow::pipeline
