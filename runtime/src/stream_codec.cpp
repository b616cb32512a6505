#include "stream_codec.h"

#include <algorithm>
#include <cstring>

namespace furrow {
namespace {

constexpr size_t kBlockBytes = 8192, kBlockElements = 256, kGroup = 16, kLeastTail = 32;

// Sixteen differences of `bits` bits, highest first in each byte; the largest value stands for a whole byte
// that follows the group. Null where the bytes end too soon.
template <unsigned kBits>
const uint8_t* unpackGroup(const uint8_t* at, const uint8_t* end, uint8_t* out) {
  constexpr size_t kPacked = kGroup * kBits / 8;
  constexpr unsigned kEscape = (1u << kBits) - 1;
  if (static_cast<size_t>(end - at) < kPacked) return nullptr;
  const uint8_t* rest = at + kPacked;
  for (unsigned i = 0; i < kGroup; ++i) {
    const unsigned value = at[i * kBits / 8] >> (8 - kBits - i * kBits % 8) & kEscape;
    if (value == kEscape) {
      if (rest == end) return nullptr;
      out[i] = *rest++;
    } else {
      out[i] = static_cast<uint8_t>(value);
    }
  }
  return rest;
}

// Differences of one byte of a block's elements: 2 bits a group that say how it is packed, then the groups.
const uint8_t* unpackBytes(const uint8_t* at, const uint8_t* end, size_t groups, uint8_t* out) {
  const uint8_t* header = at;
  if (static_cast<size_t>(end - at) < (groups + 3) / 4) return nullptr;
  at += (groups + 3) / 4;
  for (size_t g = 0; at && g < groups; ++g, out += kGroup) {
    switch (header[g / 4] >> (2 * (g % 4)) & 3) {
      case 0:
        std::fill_n(out, kGroup, uint8_t{0});
        break;
      case 1:
        at = unpackGroup<2>(at, end, out);
        break;
      case 2:
        at = unpackGroup<4>(at, end, out);
        break;
      default:
        if (static_cast<size_t>(end - at) < kGroup) return nullptr;
        std::copy_n(at, kGroup, out);
        at += kGroup;
    }
  }
  return at;
}

}  // namespace

bool decodeVertexStream(std::span<const uint8_t> bytes, size_t count, size_t stride, uint8_t* out) {
  if (stride == 0 || stride > 256 || stride % 4 != 0) return false;
  const size_t tail = std::max(kLeastTail, stride);
  if (bytes.size() < 1 + tail || bytes[0] != 0xa0) return false;
  const uint8_t* at = bytes.data() + 1;
  const uint8_t* end = bytes.data() + bytes.size() - tail;
  uint8_t last[256];  // the element before, which differences are added to; the first one ends the stream
  std::memcpy(last, bytes.data() + bytes.size() - stride, stride);

  const size_t most = std::min(kBlockBytes / stride / kGroup * kGroup, kBlockElements);
  uint8_t differences[kBlockElements];
  for (size_t first = 0; first < count; first += most, out += most * stride) {
    const size_t elements = std::min(most, count - first);
    for (size_t k = 0; k < stride; ++k) {
      at = unpackBytes(at, end, (elements + kGroup - 1) / kGroup, differences);
      if (!at) return false;
      uint8_t value = last[k];
      for (size_t i = 0; i < elements; ++i) {
        const unsigned d = differences[i];
        value = static_cast<uint8_t>(value + (d & 1 ? ~(d >> 1) : d >> 1));  // zigzag
        out[i * stride + k] = value;
      }
      last[k] = value;
    }
  }
  return at == end;
}

bool decodeIndexStream(std::span<const uint8_t> bytes, size_t count, uint32_t* out) {
  constexpr size_t kTail = 4;
  if (bytes.size() < 1 + kTail || (bytes[0] != 0xd0 && bytes[0] != 0xd1)) return false;
  const uint8_t* at = bytes.data() + 1;
  const uint8_t* end = bytes.data() + bytes.size() - kTail;
  uint32_t last[2] = {0, 0};  // two runs take turns as an index says
  for (size_t i = 0; i < count; ++i) {
    uint32_t value = 0;
    for (unsigned shift = 0;; shift += 7) {
      if (at == end || shift > 28) return false;
      value |= static_cast<uint32_t>(*at & 0x7f) << shift;
      if (!(*at++ & 0x80)) break;
    }
    uint32_t& run = last[value & 1];
    value >>= 1;
    run += value & 1 ? ~(value >> 1) : value >> 1;
    out[i] = run;
  }
  return at == end;
}

}  // namespace furrow
