#include "editor/cli/outputs.h"

#include <span>

#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {

void refuseToOverwrite(const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& inputs) {
  std::error_code ignored;
  for (const std::filesystem::path& input : inputs)
    if (std::filesystem::equivalent(input, output, ignored))
      throw pipeline::Error(pipeline::Exit::kBadUsage, output.string(), "the output would overwrite an input",
                            "choose another name for it");
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
