#pragma once

// What happens to the bytes of a finished cook.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace furrow::cli {

// Throws Error (kBadUsage) if `output` is one of the inputs.
void refuseToOverwrite(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs);

// Writes the asset, unless the file holds these bytes already and is newer than every input and this program:
// then nothing that depends on it need be made again. Returns whether it was written.
bool deliver(const std::filesystem::path& output, std::span<const std::byte> bytes,
             const std::vector<std::filesystem::path>& inputs);

void writeText(const std::filesystem::path& file, const std::string& text);

// A Make rule; spaces, '#' and '$' escaped as Make and Ninja want them.
std::string makeRule(const std::filesystem::path& target,
                     const std::vector<std::filesystem::path>& dependencies);

}  // namespace furrow::cli
