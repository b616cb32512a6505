#pragma once

// What furrow::decodeEntropyStream() (runtime/src/entropy_codec.h) reads.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace furrow::pipeline {

// `count` elements, at least one, of `stride` bytes, up to 256. The same elements give the same bytes.
std::vector<uint8_t> encodeEntropyStream(const uint8_t* data, size_t count, size_t stride);

}  // namespace furrow::pipeline
