#pragma once

// What the readers of the single formats share. Each takes the bytes of `file` and fills everything of the
// scene but `file` itself. They throw Error, or any std::exception whose what() says what is wrong with the
// file: import() turns it into an Error.

#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

enum class MeshFormat { kObj, kPly, kStlText, kStlBinary, kOff };

// Bytes of a regular file. Throws Error: kBadData when there is none at that path, kEnvironment when it
// cannot be read.
std::vector<uint8_t> readBytes(const std::filesystem::path& file);

SourceScene importGltf(const std::filesystem::path& file, std::vector<uint8_t> bytes);
SourceScene importMeshFile(const std::filesystem::path& file, MeshFormat format, std::vector<uint8_t> bytes);

}  // namespace furrow::pipeline
