#pragma once

// Reads a scene from any format furrow knows, told by content first, by extension second: glTF 2.0 (.gltf,
// .glb) through tinygltf; OBJ with its materials, PLY, STL and OFF through OpenMesh.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

// Throws Error (kBadData: the file; kEnvironment: it cannot be opened). Images are not decoded, and those
// beside the file not read.
SourceScene import(const std::filesystem::path& file);

// The same of bytes that are in memory; `file` gives the extension and the folder of what they refer to.
SourceScene importBytes(const std::filesystem::path& file, std::vector<uint8_t> bytes);

// Every file that import() would read and every image that the scene names and that is there, `file` first;
// no geometry is read. Throws the same.
std::vector<std::filesystem::path> importedFiles(const std::filesystem::path& file);

// An image of a recipe that lies in a glTF file: "head.glb#wrinkles" is the image of that name, or number.
struct EmbeddedImage {
  SourceImage image;
  std::vector<std::filesystem::path> files;  // that it is read from, the glTF file first
};

// nullopt: `path` names a file of its own. Throws as import(), and Error (kBadData) if there is no such
// image.
std::optional<EmbeddedImage> embeddedImage(const std::filesystem::path& path);

}  // namespace furrow::pipeline
