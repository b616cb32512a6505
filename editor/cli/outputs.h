#pragma once

// What commands write.

#include <filesystem>
#include <string>
#include <vector>

namespace furrow::cli {

// Throws Error (kBadUsage) if an output is one of the inputs, or two are one file. Empty names are none.
void refuseToOverwrite(const std::vector<std::filesystem::path>& outputs,
                       const std::vector<std::filesystem::path>& inputs);

// Before long work: the same, and kEnvironment for an output whose folder is not there.
void checkOutputs(const std::vector<std::filesystem::path>& outputs,
                  const std::vector<std::filesystem::path>& inputs);

// Throws Error (kEnvironment) if what was printed did not all get to standard output.
void finishPrinting();

void writeText(const std::filesystem::path& file, const std::string& text);

// A Make rule; spaces, '#' and '$' escaped as Make and Ninja want them.
std::string makeRule(const std::filesystem::path& target,
                     const std::vector<std::filesystem::path>& dependencies);

}  // namespace furrow::cli
