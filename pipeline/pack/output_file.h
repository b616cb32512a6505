#pragma once

// Files that appear whole or not at all.

#include <cstddef>
#include <filesystem>
#include <span>

namespace furrow::pipeline {

// Writes a temporary beside `file`, syncs it and renames it over `file`. Throws Error (kEnvironment) and
// leaves nothing behind.
void writeFile(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace furrow::pipeline
