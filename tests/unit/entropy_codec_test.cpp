// The decoder against the encoder, and against bytes that are no stream.

#include "entropy_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "pipeline/pack/entropy_encoder.h"

namespace furrow {
namespace {

using Bytes = std::vector<uint8_t>;

// Neighbouring elements differ by about `spread`, sometimes by anything.
Bytes noise(size_t count, size_t stride, unsigned spread, uint32_t seed) {
  std::mt19937 random(seed);
  Bytes data(count * stride);
  for (size_t i = 0; i < data.size(); ++i) {
    const bool jump = spread > 0 && random() % 13 == 0;
    const unsigned step =
        jump ? static_cast<unsigned>(random()) : static_cast<unsigned>(random()) % (spread + 1);
    data[i] = static_cast<uint8_t>((i >= stride ? data[i - stride] : 17u) + step);
  }
  return data;
}

TEST(EntropyStream, EveryShapeComesBack) {
  for (size_t stride : {1, 4, 8, 12, 16, 255, 256})
    for (size_t count : {1, 7, 8, 9, 15, 256, 1000})
      for (unsigned spread : {0, 1, 2, 7, 100, 255}) {
        const Bytes data = noise(count, stride, spread, static_cast<uint32_t>(stride + count + spread));
        const Bytes bytes = pipeline::encodeEntropyStream(data.data(), count, stride);
        Bytes out(data.size());
        ASSERT_TRUE(decodeEntropyStream(bytes, count, stride, out.data()))
            << stride << " " << count << " " << spread;
        ASSERT_EQ(out, data) << stride << " " << count << " " << spread;
      }
}

// Differences d of probability p each take -log2 p bits; widths say a part of that once more.
TEST(EntropyStream, ComesNearTheEntropy) {
  std::mt19937 random(3);
  const size_t count = 100000;
  std::geometric_distribution<int> size(0.6);
  std::map<int, double> uses;
  Bytes data(4 * count);
  for (size_t i = 4; i < data.size(); ++i) {
    const int d = size(random) * (random() % 2 ? 1 : -1);
    ++uses[d];
    data[i] = static_cast<uint8_t>(data[i - 4] + d);
  }
  double bits = 0.0;
  for (const auto& [d, n] : uses) bits -= n * std::log2(n / static_cast<double>(data.size()));
  const double bytes = static_cast<double>(pipeline::encodeEntropyStream(data.data(), count, 4).size());
  EXPECT_GT(bytes, bits / 8.0 - 4.0);
  EXPECT_LT(bytes, 1.05 * bits / 8.0);
}

TEST(EntropyStream, RefusesWhatIsNotOne) {
  const Bytes data = noise(300, 8, 5, 1), good = pipeline::encodeEntropyStream(data.data(), 300, 8);
  Bytes out(data.size());
  for (size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(decodeEntropyStream({good.data(), length}, 300, 8, out.data())) << length;
  Bytes more = good;
  more.push_back(0);
  EXPECT_FALSE(decodeEntropyStream(more, 300, 8, out.data()));
  EXPECT_FALSE(decodeEntropyStream(good, 292, 8, out.data()));
  EXPECT_FALSE(decodeEntropyStream(good, 300, 0, out.data()));
  EXPECT_FALSE(decodeEntropyStream(good, 300, 257, out.data()));
}

// Any bytes at all: no read and no write out of bounds (the sanitizers would tell).
TEST(EntropyStream, NoiseIsHarmless) {
  std::mt19937 random(9);
  const Bytes data = noise(60, 12, 9, 2), good = pipeline::encodeEntropyStream(data.data(), 60, 12);
  Bytes out(70 * 12);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    if (i % 2) bytes.resize(random() % 200);
    for (auto writes = 1 + random() % (i % 2 ? 100 : 4); writes > 0 && !bytes.empty(); --writes)
      bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
    decodeEntropyStream(bytes, random() % 71, 12, out.data());
  }
}

}  // namespace
}  // namespace furrow
