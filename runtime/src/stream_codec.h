#pragma once

// Decoders of meshoptimizer's two streams that an asset holds, by the bitstreams of glTF's
// EXT_meshopt_compression (modes ATTRIBUTES and INDICES). The library that encodes them is not always there
// to be linked statically, and a game is to need nothing but its C++ library.

#include <cstddef>
#include <cstdint>
#include <span>

namespace furrow {

// `count` elements of `stride` bytes, a multiple of 4 up to 256, into `out`. False where the bytes are not
// such a stream; `out` is then undefined.
bool decodeVertexStream(std::span<const uint8_t> bytes, size_t count, size_t stride, uint8_t* out);

bool decodeIndexStream(std::span<const uint8_t> bytes, size_t count, uint32_t* out);

}  // namespace furrow
