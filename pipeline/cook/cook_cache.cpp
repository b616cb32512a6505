#include "pipeline/cook/cook_cache.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <span>
#include <variant>

#include "furrow/asset.h"
#include "pipeline/content_key.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/input_file.h"
#include "pipeline/maps/image.h"
#include "pipeline/pack/output_file.h"
#include "pipeline/recipe/recipe.h"

namespace furrow::pipeline {
namespace {

constexpr char kMagic[8] = {'f', 'u', 'r', 'r', 'o', 'w', 'c', '2'};

// An entry is this, the warnings as lines, and the asset.
struct EntryHeader {
  char magic[8];
  uint64_t warning_bytes, payload_bytes;  // of them; of both
  uint64_t hash[2];                       // of both
};

EntryHeader headerOf(uint64_t warning_bytes, std::span<const std::byte> payload) {
  EntryHeader header{{}, warning_bytes, payload.size(), {}};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  const XXH128_hash_t hash = XXH3_128bits_withSeed(payload.data(), payload.size(), warning_bytes);
  header.hash[0] = hash.low64;
  header.hash[1] = hash.high64;
  return header;
}

std::string fileKey(const std::filesystem::path& file) {
  const std::vector<uint8_t> bytes = readBytes(file);
  return contentKey(std::as_bytes(std::span(bytes)));
}

// Of this program, so that builds of one version that differ do not take each other's assets.
const std::string& toolKey() {
  static const std::string key = contentKey(
      contentKey(FURROW_VERSION) + contentKey(std::to_string(kFormatVersion)) + fileKey("/proc/self/exe") +
      (std::filesystem::exists(imageModuleFile()) ? fileKey(imageModuleFile()) : std::string()));
  return key;
}

}  // namespace

std::vector<std::filesystem::path> filesOf(const CookRequest& request) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const std::vector<std::filesystem::path>& more) {
    files.insert(files.end(), more.begin(), more.end());
  };
  std::vector<std::filesystem::path> frames;
  if (!request.source.pattern.empty()) frames = sequenceFiles(request.source.pattern);
  if (!request.source.base.empty()) {
    add(importedFiles(request.source.base));
  } else if (!frames.empty()) {
    add(importedFiles(frames.front()));
    frames.erase(frames.begin());
  }
  add(frames);
  if (!request.recipe.empty()) {
    const Recipe recipe = readRecipe(request.recipe);
    files.push_back(recipe.file);
    add(recipe.files);
    if (const auto* rest = std::get_if<RestFile>(&recipe.rest)) add(importedFiles(rest->file));
  }
  return files;
}

std::string cookKey(const CookRequest& request, const std::vector<std::filesystem::path>& files) {
  std::string keys = toolKey();
  keys += contentKey(std::string(request.geometry == GeometryCodec::kRaw ? "raw" : "draco") +
                     (request.source.base.empty() ? "" : " base") +
                     (request.source.pattern.empty() ? "" : " frames") +
                     (request.recipe.empty() ? "" : " recipe"));
  keys += contentKey(std::as_bytes(std::span(&request.source.fps, 1)));
  for (const std::filesystem::path& file : files)
    keys += contentKey(file.filename().string()) + fileKey(file);
  return contentKey(keys);
}

std::filesystem::path CookCache::file(const std::string& key) const {
  return folder_ / key.substr(0, 2) / key.substr(2);
}

std::optional<CookCache::Entry> CookCache::find(const std::string& key) const {
  std::ifstream in(file(key), std::ios::binary);
  EntryHeader header{};
  in.read(reinterpret_cast<char*>(&header), sizeof header);
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(file(key), error);
  if (!in || error || size - sizeof header != header.payload_bytes ||
      header.warning_bytes > header.payload_bytes)
    return std::nullopt;
  std::vector<std::byte> payload(header.payload_bytes);
  in.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
  const EntryHeader wanted = headerOf(header.warning_bytes, payload);
  if (!in || std::memcmp(&header, &wanted, sizeof header) != 0) return std::nullopt;

  Entry entry;
  const auto asset = payload.begin() + static_cast<std::ptrdiff_t>(header.warning_bytes);
  std::string line;
  for (auto byte = payload.begin(); byte != asset; ++byte) {
    if (*byte != std::byte{'\n'}) {
      line += static_cast<char>(*byte);
      continue;
    }
    entry.warnings.push_back(std::move(line));
    line.clear();
  }
  entry.bytes.assign(asset, payload.end());
  std::filesystem::last_write_time(file(key), std::filesystem::file_time_type::clock::now(), error);
  return entry;
}

void CookCache::store(const std::string& key, const Entry& entry) const {
  std::string warnings;
  for (const std::string& warning : entry.warnings) warnings += warning + '\n';
  std::vector<std::byte> bytes(sizeof(EntryHeader));
  const std::span<const std::byte> text = std::as_bytes(std::span(warnings));
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.insert(bytes.end(), entry.bytes.begin(), entry.bytes.end());
  const EntryHeader header = headerOf(warnings.size(), std::span(bytes).subspan(sizeof header));
  std::memcpy(bytes.data(), &header, sizeof header);
  std::error_code ignored;
  std::filesystem::create_directories(file(key).parent_path(), ignored);
  writeFile(file(key), bytes);
}

std::filesystem::path defaultCacheFolder() {
  const auto variable = [](const char* name) -> std::filesystem::path {
    const char* const value = std::getenv(name);
    return value ? value : "";
  };
  if (const auto cache = variable("XDG_CACHE_HOME"); cache.is_absolute()) return cache / "furrow";
  if (const auto home = variable("HOME"); home.is_absolute()) return home / ".cache" / "furrow";
  return {};
}

}  // namespace furrow::pipeline
