#include "editor/preview/loaded_asset.h"

#include <cstring>
#include <fstream>
#include <vector>

#include "pipeline/error.h"
#include "pipeline/pack/rig_section.h"

namespace furrow::preview {
namespace {

using pipeline::Error;
using pipeline::Exit;

constexpr const char* kRemedy = "cook it again from its source with 'furrow cook'";

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

}  // namespace

bool looksLikeAsset(const std::filesystem::path& file) {
  char magic[6] = {};
  std::ifstream in(file, std::ios::binary);
  in.read(magic, sizeof magic);
  return file.extension() == ".furrow" || (in && std::memcmp(magic, "furrow", sizeof magic) == 0);
}

LoadedAsset loadAsset(const std::filesystem::path& file) {
  return loadAsset(file, readFile(file));
}

LoadedAsset loadAsset(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  LoadedAsset loaded;
  loaded.file = file;
  loaded.bytes = bytes.size();
  if (const Status status = loaded.asset.load(bytes); !status.ok())
    throw Error(Exit::kBadData, file.string(), status.message, kRemedy);
  try {
    loaded.rig = pipeline::readRig(loaded.asset.view());
  } catch (const std::exception& error) {
    throw Error(Exit::kBadData, file.string(), error.what(), kRemedy);
  }
  if (loaded.rig.morphs.size() != loaded.asset.view().morphs.size())
    throw Error(Exit::kBadData, file.string(), "its rig does not fit its geometry", kRemedy);
  return loaded;
}

}  // namespace furrow::preview
