#include "editor/preview/loaded_asset.h"

#include <cstring>
#include <fstream>
#include <vector>

#include "pipeline/error.h"
#include "pipeline/input_file.h"
#include "pipeline/pack/rig_section.h"

namespace furrow::preview {
namespace {

using pipeline::Error;
using pipeline::Exit;

constexpr const char* kRemedy = "cook it again from its source with 'furrow cook'";

}  // namespace

bool looksLikeAsset(const std::filesystem::path& file) {
  char magic[6] = {};
  std::error_code ignored;
  if (file.extension() == ".furrow") return true;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::ifstream in(file, std::ios::binary);
  in.read(magic, sizeof magic);
  return in && std::memcmp(magic, "furrow", sizeof magic) == 0;
}

LoadedAsset loadAsset(const std::filesystem::path& file) {
  const std::vector<uint8_t> bytes = pipeline::readBytes(file);
  return loadAsset(file, std::as_bytes(std::span(bytes)));
}

LoadedAsset loadAsset(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  Asset asset;
  if (const Status status = asset.load(bytes); !status.ok())
    throw Error(Exit::kBadData, file.string(), status.message, kRemedy);
  return withRig(file, bytes, std::move(asset));
}

LoadedAsset withRig(const std::filesystem::path& file, std::span<const std::byte> bytes, Asset asset) {
  LoadedAsset loaded;
  loaded.file = file;
  loaded.bytes = bytes.size();
  loaded.asset = std::move(asset);
  loaded.sections = pipeline::sectionBytes(bytes);
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
