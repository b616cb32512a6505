#pragma once

// The bytes of a place hash and the function they encode: shared by the reader (place_hash.cpp) and the
// builder (pipeline/bake/perfect_hash.cpp). docs/format.md describes both in words.

#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "furrow/types.h"

namespace furrow::place_hash {

static_assert(std::endian::native == std::endian::little,
              "a place hash is read and written as it lies in memory");

inline constexpr uint32_t kMagic = 0x48504c46;  // "FLPH"
inline constexpr uint32_t kVersion = 2;
inline constexpr uint32_t kMaxPlaces = 1u << 30;
inline constexpr uint32_t kPilots = 256;  // a pilot is a byte

// Followed by uint8 pilots[bucket_count], zeros up to a multiple of 4, uint32 spill[slot_count - place_count]
// and uint16 checks[place_count].
struct Header {
  uint32_t magic, version;
  uint32_t place_count, bucket_count, slot_count;
  uint32_t seed;

  uint64_t spillBegin() const { return sizeof(Header) + ((uint64_t{bucket_count} + 3) & ~uint64_t{3}); }
  uint64_t checksBegin() const {
    return spillBegin() + (uint64_t{slot_count} - place_count) * sizeof(uint32_t);
  }
  uint64_t size() const { return checksBegin() + uint64_t{place_count} * sizeof(uint16_t); }
};
static_assert(sizeof(Header) == 24);

// What is hashed of a position: its bits, -0 turned into 0, each pair in one word so that the hash reads what
// was just written whole.
struct Key {
  uint64_t xy, z;

  explicit Key(const Float3& p) : xy(bits(p.x) | bits(p.y) << 32), z(bits(p.z)) {}
  auto operator<=>(const Key&) const = default;

 private:
  static uint64_t bits(float x) {
    uint32_t bits = std::bit_cast<uint32_t>(x);
    return bits == 0x80000000u ? 0 : bits;
  }
};
static_assert(sizeof(Key) == 16);

inline uint64_t hashOf(const Key& key, uint32_t seed) {
  return XXH3_64bits_withSeed(&key, sizeof(key), seed);
}

// The upper half of the hash picks the bucket, its lowest quarter is the check, and all of it with the
// bucket's pilot picks the slot.
inline uint16_t checkOf(uint64_t hash) {
  return static_cast<uint16_t>(hash);
}

inline uint32_t bucketOf(uint64_t hash, uint32_t bucket_count) {
  return static_cast<uint32_t>((hash >> 32) * bucket_count >> 32);
}

inline uint32_t slotOf(uint64_t hash, uint32_t pilot, uint32_t slot_count) {
  uint64_t mixed = (hash ^ pilot * 0x9e3779b97f4a7c15u) * 0xd6e8feb86659fd93u;
  return static_cast<uint32_t>((mixed >> 32) * slot_count >> 32);
}

}  // namespace furrow::place_hash
