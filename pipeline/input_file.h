#pragma once

// The files that a person names.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace furrow::pipeline {

// The whole of a regular file. Throws Error (kBadData: it is not there, or is a folder, a pipe or a device,
// which might never come to an end; kEnvironment: it cannot be opened or read).
std::vector<uint8_t> readBytes(const std::filesystem::path& file);

}  // namespace furrow::pipeline
