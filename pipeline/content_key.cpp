#include "pipeline/content_key.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace furrow::pipeline {

std::string contentKey(std::span<const std::byte> bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return std::to_string(hash.high64) + ' ' + std::to_string(hash.low64);
}

}  // namespace furrow::pipeline
