#pragma once

// Cooks that need not be done again.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/import/sequence.h"
#include "pipeline/pack/geometry_codec.h"

namespace furrow::pipeline {

// All that decides the bytes of an asset, but for what the files hold.
struct CookRequest {
  Sequence source;               // or its base alone
  std::filesystem::path recipe;  // empty: the default one
  GeometryCodec geometry = GeometryCodec::kDraco;
};

// Every file the cook may read: source and its buffers or frames, recipe, the files it names and their
// buffers. Throws Error as the cook would.
std::vector<std::filesystem::path> filesOf(const CookRequest& request);

// 32 hex digits, a hash (XXH3, 128 bits) of the tool (version, format, its own bytes), the request and of the
// name and the bytes of every one of `files`, filesOf(request). Folders do not matter. Throws Error if one
// cannot be read.
std::string cookKey(const CookRequest& request, const std::vector<std::filesystem::path>& files);

// A folder of assets by their keys. Any number of threads and processes may use it at once, and any of its
// files may be deleted at any time; their times tell when they were last used.
class CookCache {
 public:
  explicit CookCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  struct Entry {
    std::vector<std::byte> bytes;       // of the asset
    std::vector<std::string> warnings;  // of its cook
  };

  // An entry that is damaged counts as none; store() replaces it.
  std::optional<Entry> find(const std::string& key) const;

  // Throws Error (kEnvironment).
  void store(const std::string& key, const Entry& entry) const;

 private:
  std::filesystem::path file(const std::string& key) const;

  std::filesystem::path folder_;
};

// $XDG_CACHE_HOME/furrow, else $HOME/.cache/furrow; empty if neither is set.
std::filesystem::path defaultCacheFolder();

}  // namespace furrow::pipeline
