#include "editor/cli/outputs.h"

#include <cstdio>
#include <set>
#include <span>

#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {

void refuseToOverwrite(const std::vector<std::filesystem::path>& outputs,
                       const std::vector<std::filesystem::path>& inputs) {
  std::error_code ignored;
  std::set<std::filesystem::path> names;
  for (const std::filesystem::path& output : outputs) {
    if (output.empty() || std::filesystem::is_other(output, ignored)) continue;
    const auto refuse = [&](const char* what) {
      throw pipeline::Error(pipeline::Exit::kBadUsage, output.string(), what, "choose another name for it");
    };
    if (!names.insert(std::filesystem::absolute(output, ignored).lexically_normal()).second)
      refuse("two outputs have this name");
    for (const std::filesystem::path& input : inputs)
      if (std::filesystem::equivalent(input, output, ignored)) refuse("the output would overwrite an input");
  }
}

void checkOutputs(const std::vector<std::filesystem::path>& outputs,
                  const std::vector<std::filesystem::path>& inputs) {
  std::error_code ignored;
  for (const std::filesystem::path& output : outputs)
    if (const std::filesystem::path folder = output.parent_path();
        !folder.empty() && !std::filesystem::exists(folder, ignored))
      throw pipeline::Error(pipeline::Exit::kEnvironment, output.string(),
                            "cannot be written, as its folder is not there",
                            "make it first, or choose another");
  refuseToOverwrite(outputs, inputs);
}

void finishPrinting() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout))
    throw pipeline::Error(pipeline::Exit::kEnvironment, "standard output", "cannot be written",
                          "send it where there is room");
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
