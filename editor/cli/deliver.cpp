#include "editor/cli/deliver.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {
namespace {

bool holds(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::error_code error;
  if (std::filesystem::file_size(file, error) != bytes.size() || error) return false;
  std::ifstream in(file, std::ios::binary);
  return std::equal(std::istreambuf_iterator<char>(in), {}, reinterpret_cast<const char*>(bytes.data()),
                    reinterpret_cast<const char*>(bytes.data()) + bytes.size());
}

bool isNewer(const std::filesystem::path& file, std::vector<std::filesystem::path> inputs) {
  std::error_code error;
  inputs.push_back(std::filesystem::read_symlink("/proc/self/exe", error));  // build rules depend on the tool
  const auto time = std::filesystem::last_write_time(file, error);
  return !error && std::all_of(inputs.begin(), inputs.end(), [&](const std::filesystem::path& input) {
    return std::filesystem::last_write_time(input, error) < time && !error;
  });
}

}  // namespace

void refuseToOverwrite(const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& inputs) {
  std::error_code ignored;
  for (const std::filesystem::path& input : inputs)
    if (std::filesystem::equivalent(input, output, ignored))
      throw pipeline::Error(pipeline::Exit::kBadUsage, output.string(), "the output would overwrite an input",
                            "choose another name for it");
}

bool deliver(const std::filesystem::path& output, std::span<const std::byte> bytes,
             const std::vector<std::filesystem::path>& inputs) {
  if (isNewer(output, inputs) && holds(output, bytes)) return false;
  pipeline::writeFile(output, bytes);
  return true;
}

void writeText(const std::filesystem::path& file, const std::string& text) {
  pipeline::writeFile(file, std::as_bytes(std::span(text)));
}

std::string makeRule(const std::filesystem::path& target,
                     const std::vector<std::filesystem::path>& dependencies) {
  const auto escaped = [](const std::filesystem::path& path) {
    std::string text;
    for (char c : path.string()) {
      if (c == ' ' || c == '#') text += '\\';
      text += c;
      if (c == '$') text += '$';
    }
    return text;
  };
  std::string text = escaped(target) + ":";
  for (const std::filesystem::path& file : dependencies) text += " \\\n  " + escaped(file);
  return text + "\n";
}

}  // namespace furrow::cli
