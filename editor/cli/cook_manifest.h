#pragma once

// `furrow cook --manifest`: many cooks at once.

#include <cstdint>
#include <filesystem>

namespace furrow::cli {

struct ManifestOptions {
  std::filesystem::path manifest;
  std::filesystem::path cache;    // empty: none
  std::filesystem::path depfile;  // empty: none
  uint32_t jobs = 1;              // cooks at a time
  uint32_t threads = 1;           // of all of them together
  bool quiet = false;
};

// Cooks in processes of their own, so that one that dies takes none with it. Goes on after a failure, and
// throws Error (kBadData) at the end.
void cookManifest(const ManifestOptions& options);

}  // namespace furrow::cli
