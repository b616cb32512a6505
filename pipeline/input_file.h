#pragma once

// The files that a person names.

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

namespace furrow::pipeline {

// The file that a model in `folder` names, with slashes of any system.
std::filesystem::path namedFile(std::string_view name, const std::filesystem::path& folder);

// The whole of a regular file. Throws Error (kBadData: it is not there, or is a folder, a pipe or a device,
// which might never come to an end; kEnvironment: it cannot be opened or read).
std::vector<uint8_t> readBytes(const std::filesystem::path& file);

}  // namespace furrow::pipeline
