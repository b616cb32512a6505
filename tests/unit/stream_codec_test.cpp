// The runtime's decoders against the library that encodes.

#include "stream_codec.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <random>
#include <vector>

namespace {

using Bytes = std::vector<uint8_t>;

Bytes encoded(const Bytes& data, size_t stride) {
  const size_t count = data.size() / stride;
  Bytes out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data.data(), count, stride));
  return out;
}

Bytes encoded(const std::vector<uint32_t>& indices) {
  Bytes out(meshopt_encodeIndexSequenceBound(indices.size(), 0xffffffff));
  out.resize(meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
  return out;
}

// Neighbouring elements differ by about `spread`, so that every kind of packing occurs.
Bytes noise(size_t count, size_t stride, unsigned spread, uint32_t seed) {
  std::mt19937 random(seed);
  Bytes data(count * stride);
  for (size_t i = 0; i < data.size(); ++i) {
    const bool jump = random() % 13 == 0;
    const auto any = static_cast<unsigned>(random());
    const unsigned step = spread == 0 ? 0 : jump ? any : any % spread;
    data[i] = static_cast<uint8_t>((i >= stride ? data[i - stride] : 17u) + step);
  }
  return data;
}

TEST(VertexStream, EveryShapeThatTheLibraryEncodes) {
  for (size_t stride : {4, 8, 12, 16, 36, 64, 256})
    for (size_t count : {1, 15, 16, 17, 31, 255, 256, 257, 1000})
      for (unsigned spread : {0, 2, 3, 7, 200}) {
        const Bytes data = noise(count, stride, spread, static_cast<uint32_t>(stride + count + spread));
        const Bytes bytes = encoded(data, stride);
        Bytes out(data.size());
        ASSERT_TRUE(furrow::decodeVertexStream(bytes, count, stride, out.data()));
        ASSERT_EQ(out, data) << stride << " " << count << " " << spread;
      }
}

TEST(VertexStream, RefusesWhatIsNotOne) {
  const Bytes data = noise(300, 8, 5, 1), good = encoded(data, 8);
  Bytes out(data.size());
  for (size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(furrow::decodeVertexStream({good.data(), length}, 300, 8, out.data())) << length;
  Bytes more = good;
  more.push_back(0);
  EXPECT_FALSE(furrow::decodeVertexStream(more, 300, 8, out.data()));
  Bytes other = good;
  other[0] ^= 1;
  EXPECT_FALSE(furrow::decodeVertexStream(other, 300, 8, out.data()));
  EXPECT_FALSE(furrow::decodeVertexStream(good, 300, 6, out.data()));
  EXPECT_FALSE(furrow::decodeVertexStream(good, 300, 0, out.data()));
  EXPECT_FALSE(furrow::decodeVertexStream(good, 100, 8, out.data()));
}

TEST(IndexStream, EverySequence) {
  std::mt19937 random(2);
  // The encoder itself loses differences from 2^30.
  for (uint32_t spread : {1u, 2u, 100u, 100000u, 1u << 29})
    for (size_t count : {1, 2, 3, 1000}) {
      std::vector<uint32_t> indices(count);
      for (uint32_t& index : indices) index = static_cast<uint32_t>(random()) % spread;
      const Bytes bytes = encoded(indices);
      std::vector<uint32_t> out(count);
      ASSERT_TRUE(furrow::decodeIndexStream(bytes, count, out.data()));
      ASSERT_EQ(out, indices);
    }
}

TEST(IndexStream, RefusesWhatIsNotOne) {
  std::vector<uint32_t> indices(100), out(100);
  for (uint32_t i = 0; i < 100; ++i) indices[i] = i * 7919u % 1000u;
  const Bytes good = encoded(indices);
  for (size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(furrow::decodeIndexStream({good.data(), length}, 100, out.data())) << length;
  EXPECT_FALSE(furrow::decodeIndexStream(good, 99, out.data()));
  const Bytes endless = {0xd1, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0};
  EXPECT_FALSE(furrow::decodeIndexStream(endless, 1, out.data()));
}

// Any bytes at all: no read and no write out of bounds (the sanitizers would tell).
TEST(Streams, NoiseIsHarmless) {
  std::mt19937 random(9);
  Bytes out(300 * 12);
  std::vector<uint32_t> indices(300);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(random() % 200);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    if (!bytes.empty()) bytes[0] = i % 2 ? 0xa0 : 0xd1;
    furrow::decodeVertexStream(bytes, random() % 301, 12, out.data());
    furrow::decodeIndexStream(bytes, random() % 301, indices.data());
  }
}

}  // namespace
