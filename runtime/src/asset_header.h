#pragma once

// The 32 bytes in front of a .furrow file's FlatBuffers payload.

#include <cstdint>

namespace furrow {

struct AssetHeader {
  char magic[8];           // kAssetMagic
  uint32_t version;        // kFormatVersion of the tool that wrote it
  uint32_t reserved;       // 0
  uint64_t payload_bytes;  // what follows the header
  uint64_t payload_hash;   // XXH3-64 of the payload, seeded with the version
};
static_assert(sizeof(AssetHeader) == 32);

inline constexpr char kAssetMagic[8] = {'f', 'u', 'r', 'r', 'o', 'w', '\r', '\n'};

}  // namespace furrow
