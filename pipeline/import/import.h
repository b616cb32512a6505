#pragma once

// Reads a scene from any format furrow knows, told by content first, by extension second: glTF 2.0 (.gltf,
// .glb) through tinygltf; OBJ with its materials, PLY, STL and OFF through OpenMesh.

#include <cstdint>
#include <filesystem>
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

}  // namespace furrow::pipeline
