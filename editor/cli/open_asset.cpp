#include "editor/cli/open_asset.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/pack/rig_section.h"

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;

std::vector<std::byte> readFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw Error(Exit::kBadData, file.string(), "there is no such file", "check the path");
  if (std::filesystem::is_directory(file, error))
    throw Error(Exit::kBadData, file.string(), "it is a folder", "name a file");
  std::ifstream in(file, std::ios::binary);
  std::vector<std::byte> bytes(std::filesystem::file_size(file, error));
  if (!in || error ||
      !in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
    throw Error(Exit::kEnvironment, file.string(), "it cannot be read", "check its permissions");
  return bytes;
}

bool looksLikeAsset(const std::filesystem::path& file) {
  char magic[6] = {};
  std::ifstream in(file, std::ios::binary);
  in.read(magic, sizeof magic);
  return file.extension() == ".furrow" || (in && std::memcmp(magic, "furrow", sizeof magic) == 0);
}

}  // namespace

OpenedAsset openAsset(const std::filesystem::path& file) {
  OpenedAsset opened;
  opened.file = file;
  std::vector<std::byte> bytes;
  if (looksLikeAsset(file)) {
    bytes = readFile(file);
  } else {
    pipeline::Cooked cooked = cookFile({.pattern = {}, .base = file}, {}, {}, false);
    bytes = std::move(cooked.bytes);
    opened.warnings = std::move(cooked.report.warnings);
    opened.cooked_here = true;
  }
  opened.bytes = bytes.size();
  if (const Status status = opened.asset.load(bytes); !status.ok())
    throw Error(Exit::kBadData, file.string(), status.message,
                "cook it again from its source with 'furrow cook'");
  try {
    opened.rig = pipeline::readRig(opened.asset.view().rig);
  } catch (const std::exception& error) {
    throw Error(Exit::kBadData, file.string(), error.what(),
                "cook it again from its source with 'furrow cook'");
  }
  if (opened.rig.palette.size() != opened.asset.view().palette.size() ||
      opened.rig.morphs.size() != opened.asset.view().morphs.size())
    throw Error(Exit::kBadData, file.string(), "its rig does not fit its geometry",
                "cook it again from its source with 'furrow cook'");
  return opened;
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

void printWarnings(const std::filesystem::path& source, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings)
    std::fprintf(stderr, "furrow: %s: warning: %s\n", source.c_str(), warning.c_str());
}

}  // namespace furrow::cli
