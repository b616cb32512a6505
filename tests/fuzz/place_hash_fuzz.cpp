#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "furrow/place_hash.h"

// Any bytes: open() refuses them, or every find() stays in range. The last 12 bytes are a position, too.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  furrow::PlaceHash hash;
  furrow::Float3 position{};
  if (size >= sizeof(position)) std::memcpy(&position, data + size - sizeof(position), sizeof(position));
  if (!hash.open(std::as_bytes(std::span(data, size))).ok()) return 0;
  for (float x : {position.x, 0.0f, 1.0f, -2.5f})
    if (auto place = hash.find({x, position.y, position.z}); place && *place >= hash.placeCount())
      std::abort();
  return 0;
}
