#pragma once

// What the readers of the single formats share. Each takes the bytes of `file` and fills everything of the
// scene but `file` itself. They throw Error, or any std::exception whose what() says what is wrong with the
// file: import() turns it into an Error.

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipeline/import/import.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

// Of the colour maps of blended materials: what is less opaque there is cut out.
inline constexpr float kBlendCutoff = 0.35f;

enum class MeshFormat { kObj, kPly, kStlText, kStlBinary, kOff };

SourceScene importGltf(const std::filesystem::path& file, std::vector<uint8_t> bytes);
// The files of its buffers, and of the images that a cook may read as far as they are there.
std::vector<std::filesystem::path> gltfFiles(const std::filesystem::path& file,
                                             const std::vector<uint8_t>& bytes);

EmbeddedImage gltfImage(const std::filesystem::path& file, std::vector<uint8_t> bytes,
                        const std::string& name);

// The faces of a mesh file as they stand in it: not split at seams, not cut into triangles.
struct Polygons {
  std::vector<glm::vec3> positions;  // the file's vertices; finite where a face has them
  std::vector<uint32_t> corners;     // vertices, face after face
  std::vector<uint32_t> ends;        // of every face, in corners
};
Polygons importPolygons(const std::filesystem::path& file);  // as import(), which tells the format
Polygons polygonsOf(MeshFormat format, std::vector<uint8_t> bytes);

// The material files and images of a mesh file, as far as they are there.
std::vector<std::filesystem::path> meshFiles(const std::filesystem::path& file, MeshFormat format,
                                             std::vector<uint8_t> bytes);

SourceScene importMeshFile(const std::filesystem::path& file, MeshFormat format, std::vector<uint8_t> bytes);

}  // namespace furrow::pipeline
