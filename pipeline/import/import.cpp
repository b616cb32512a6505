#include "pipeline/import/import.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <new>
#include <optional>
#include <string_view>

#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/input_file.h"

namespace furrow::pipeline {
namespace {

constexpr size_t kStlHeader = 84;
constexpr size_t kStlTriangle = 50;
constexpr size_t kMostNumbers = size_t{1} << 30;

std::string_view skipSpace(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == std::string_view::npos ? std::string_view{} : text.substr(begin);
}

// Its header may say "solid", and bytes may follow it or be missing; then the name must say STL.
bool isBinaryStl(const std::vector<uint8_t>& bytes, bool named_stl) {
  if (bytes.size() < kStlHeader) return false;
  uint32_t triangles = 0;
  std::memcpy(&triangles, bytes.data() + kStlHeader - sizeof triangles, sizeof triangles);
  if (bytes.size() == kStlHeader + kStlTriangle * static_cast<size_t>(triangles)) return true;
  return named_stl &&
         std::find(bytes.begin(), bytes.begin() + kStlHeader, uint8_t{0}) != bytes.begin() + kStlHeader;
}

// "OFF" with any of the prefixes that say what a vertex holds: ST, C, N, 4, n. Comments may stand before it,
// and a file that is named so need not say it.
bool isOff(std::string_view text, bool named_off) {
  while (named_off && text.starts_with('#'))
    text = skipSpace(text.substr(std::min(text.find('\n'), text.size())));
  if (named_off && !text.empty() && std::isdigit(static_cast<unsigned char>(text.front()))) return true;
  const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n"));
  return word.ends_with("OFF") && word.find_first_not_of("STCN4n") == word.size() - 3;
}

std::string extensionOf(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// nullopt: glTF.
std::optional<MeshFormat> tellFormat(const std::filesystem::path& file, const std::vector<uint8_t>& bytes) {
  const std::string_view raw(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string_view text = skipSpace(raw);
  const std::string extension = extensionOf(file);
  if (raw.starts_with("\xFF\xFE") || raw.starts_with("\xFE\xFF"))
    throw Error(Exit::kBadData, file.string(), "it is UTF-16 text", "save it as UTF-8");
  if (raw.starts_with("glTF") || text.starts_with('{')) return std::nullopt;
  if (raw.starts_with("ply\n") || raw.starts_with("ply\r")) return MeshFormat::kPly;
  if (isBinaryStl(bytes, extension == ".stl")) return MeshFormat::kStlBinary;
  if (isOff(text, extension == ".off")) return MeshFormat::kOff;
  if (extension == ".obj") return MeshFormat::kObj;
  if (text.starts_with("solid") || extension == ".stl") return MeshFormat::kStlText;
  if (extension == ".gltf" || extension == ".glb")
    throw Error(Exit::kBadData, file.string(), "not glTF (neither JSON nor a GLB container)",
                "export it again");
  if (extension == ".ply" || extension == ".off")
    throw Error(Exit::kBadData, file.string(),
                std::string("does not begin as ") + (extension == ".ply" ? "a PLY" : "an OFF") + " file does",
                "export it again");
  if (raw.starts_with("furrow\r\n"))
    throw Error(Exit::kBadData, file.string(), "it is a cooked asset",
                "give the file that it was cooked from");
  throw Error(Exit::kBadData, file.string(), "not a format that furrow reads",
              "give it glTF, GLB, OBJ, PLY, STL or OFF");
}

std::vector<uint8_t> readModel(const std::filesystem::path& file) {
  std::vector<uint8_t> bytes = readBytes(file);
  if (bytes.empty()) throw Error(Exit::kBadData, file.string(), "the file is empty", "export it again");
  return bytes;
}

// The first line of a library's message, short enough to print.
std::string firstLine(std::string_view message) {
  constexpr size_t kLongest = 240;
  message = message.substr(0, std::min(message.find('\n'), kLongest));
  while (message.ends_with('.') || message.ends_with(' ')) message.remove_suffix(1);
  return std::string(message);
}

// read(), whose faults become Errors that name the file.
template <typename Read>
auto guarded(const std::filesystem::path& file, const Read& read) {
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(Exit::kBadData, file.string(), "it asks for more memory than there is", "export it again");
  } catch (const std::exception& e) {
    throw Error(Exit::kBadData, file.string(), firstLine(e.what()), "export it again");
  }
}

// All parts together are numbered in 32 bits. A mesh counts as often as nodes show it.
void requireCountable(const SourceScene& scene) {
  size_t vertices = 0, corners = 0;
  for (const Part& part : scene.parts) {
    vertices += scene.primitives[part.primitive].positions.size();
    corners += scene.primitives[part.primitive].indices.size();
  }
  if (std::max(vertices, corners) > kMostNumbers)
    throw Error(Exit::kBadData, scene.file.string(),
                "its nodes show " + std::to_string(vertices) + " vertices and " +
                    std::to_string(corners / 3) + " triangles together",
                "split it into files of at most 2^30 vertices and 2^30 / 3 triangles");
}

SourceScene sceneOf(const std::filesystem::path& file, std::vector<uint8_t> bytes) {
  const std::optional<MeshFormat> format = tellFormat(file, bytes);
  SourceScene scene =
      format ? importMeshFile(file, *format, std::move(bytes)) : importGltf(file, std::move(bytes));
  scene.file = file;
  requireCountable(scene);
  return scene;
}

}  // namespace

SourceScene import(const std::filesystem::path& file) {
  return guarded(file, [&] { return sceneOf(file, readModel(file)); });
}

SourceScene importBytes(const std::filesystem::path& file, std::vector<uint8_t> bytes) {
  return guarded(file, [&] { return sceneOf(file, std::move(bytes)); });
}

std::vector<std::filesystem::path> importedFiles(const std::filesystem::path& file) {
  return guarded(file, [&] {
    std::vector<uint8_t> bytes = readModel(file);
    const std::optional<MeshFormat> format = tellFormat(file, bytes);
    std::vector<std::filesystem::path> files;
    if (!format) files = gltfFiles(file, bytes);
    if (format) files = meshFiles(file, *format, std::move(bytes));
    files.insert(files.begin(), file);
    return files;
  });
}

std::optional<EmbeddedImage> embeddedImage(const std::filesystem::path& path) {
  const std::string text = path.string();
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) return std::nullopt;
  for (size_t at = text.find('#'); at != std::string::npos; at = text.find('#', at + 1)) {
    const std::filesystem::path model = text.substr(0, at);
    const std::string extension = extensionOf(model);
    if ((extension != ".glb" && extension != ".gltf") || !std::filesystem::is_regular_file(model, ignored))
      continue;
    return guarded(model, [&] { return gltfImage(model, readModel(model), text.substr(at + 1)); });
  }
  return std::nullopt;
}

Polygons importPolygons(const std::filesystem::path& file) {
  return guarded(file, [&] {
    std::vector<uint8_t> bytes = readModel(file);
    const std::optional<MeshFormat> format = tellFormat(file, bytes);
    if (!format)
      throw Error(Exit::kBadData, file.string(), "glTF cannot be a part of a sequence",
                  "give OBJ, PLY, STL or OFF, or the animation as glTF");
    return polygonsOf(*format, std::move(bytes));
  });
}

}  // namespace furrow::pipeline
