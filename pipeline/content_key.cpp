#include "pipeline/content_key.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>

namespace furrow::pipeline {

std::string contentKey(std::span<const std::byte> bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  char text[33];
  std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return text;
}

std::string contentKey(const std::string& text) {
  return contentKey(std::as_bytes(std::span(text)));
}

}  // namespace furrow::pipeline
