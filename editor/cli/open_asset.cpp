#include "editor/cli/open_asset.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/one_line.h"

namespace furrow::cli {

void AssetOptions::add(CLI::App& command, const char* name) {
  command.add_option(name, file, "A .furrow file, or a source to cook in memory")->required();
  command.add_option("--recipe", recipe, "Recipe (JSON) that a source is cooked with");
}

OpenedAsset AssetOptions::open() const {
  if (preview::looksLikeAsset(file)) {
    if (!recipe.empty())
      throw pipeline::Error(pipeline::Exit::kBadUsage, file, "it is cooked already and takes no recipe",
                            "name its source in its place");
    return {preview::loadAsset(file), false, {}};
  }
  pipeline::Cooked cooked = cookFile({.pattern = {}, .base = file}, recipe, {}, false);
  return {preview::loadAsset(file, cooked.bytes), true, std::move(cooked.report.warnings)};
}

pipeline::Cooked cookFile(const pipeline::Sequence& source, const std::filesystem::path& recipe,
                          pipeline::CookOptions options, bool quiet) {
  const bool terminal = !quiet && ::isatty(STDERR_FILENO);
  if (terminal)
    options.progress = [&](const char* stage) {
      std::fprintf(stderr, "\r\033[Kfurrow: %s: %s ...", source.name().c_str(), stage);
    };
  options.progress("importing");
  struct ClearLine {
    bool on;
    ~ClearLine() {
      if (on) std::fprintf(stderr, "\r\033[K");
    }
  };
  pipeline::Cooked cooked;
  {
    const ClearLine clear{terminal};
    const auto begin = std::chrono::steady_clock::now();
    pipeline::SourceScene scene =
        source.pattern.empty() ? pipeline::import(source.base) : pipeline::importSequence(source);
    const std::chrono::duration<double> importing = std::chrono::steady_clock::now() - begin;
    cooked = pipeline::cook(
        std::move(scene), recipe.empty() ? pipeline::defaultRecipe() : pipeline::readRecipe(recipe), options);
    cooked.report.stages.insert(cooked.report.stages.begin(), {"importing", importing.count()});
  }
  return cooked;
}

std::string warningLines(const std::filesystem::path& source, const std::vector<std::string>& warnings) {
  std::string lines;
  for (const std::string& warning : warnings)
    lines += pipeline::oneLine("furrow: " + source.string() + ": warning: " + warning) + '\n';
  return lines;
}

void printWarnings(const std::filesystem::path& source, const std::vector<std::string>& warnings) {
  std::fputs(warningLines(source, warnings).c_str(), stderr);
}

}  // namespace furrow::cli
