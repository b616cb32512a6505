#pragma once

// Streams whose neighbouring elements are alike: the byte differences of meshoptimizer's vertex codec,
// through an entropy coder (Duda 2013, Asymmetric numeral systems, range variant; Giesen 2014, Interleaved
// entropy coders). docs/format.md describes the bytes; pipeline/pack/entropy_encoder.cpp writes them.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace furrow {

namespace entropy {

inline constexpr size_t kGroup = 8;      // elements, whose differences in one byte share a width
inline constexpr uint32_t kWidths = 9;   // 0 to 8 bits
inline constexpr uint32_t kTopBits = 4;  // of a difference that a table codes; those below follow as they are
inline constexpr uint32_t kShareBits = 10;  // the shares of a table's symbols sum up to 2^10
inline constexpr uint32_t kLeastState = 1u << 16;
inline constexpr size_t kStates = 4;  // a group's differences go through them in turn

// One for a width by the width before it in the same byte, then one for the differences of every width
// from 1.
inline constexpr uint32_t kTables = kWidths + kWidths - 1;
inline constexpr uint32_t tableOf(uint32_t width) {
  return kWidths + width - 1;
}
inline constexpr uint32_t lowBits(uint32_t width) {
  return width - std::min(width, kTopBits);
}
inline constexpr uint32_t symbolsOf(uint32_t table) {
  return table < kWidths ? kWidths : 1u << std::min(table - kWidths + 1, kTopBits);
}

}  // namespace entropy

// `count` elements of `stride` bytes, up to 256, into `out`. False where the bytes are not such a stream;
// `out` is then undefined.
bool decodeEntropyStream(std::span<const uint8_t> bytes, size_t count, size_t stride, uint8_t* out);

}  // namespace furrow
