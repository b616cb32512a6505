#pragma once

// What commands write.

#include <filesystem>
#include <string>
#include <vector>

namespace furrow::cli {

// Throws Error (kBadUsage) if `output` is one of the inputs.
void refuseToOverwrite(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs);

void writeText(const std::filesystem::path& file, const std::string& text);

// A Make rule; spaces, '#' and '$' escaped as Make and Ninja want them.
std::string makeRule(const std::filesystem::path& target,
                     const std::vector<std::filesystem::path>& dependencies);

}  // namespace furrow::cli
