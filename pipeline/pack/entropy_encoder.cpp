#include "pipeline/pack/entropy_encoder.h"

#include <algorithm>
#include <array>
#include <bit>

#include "entropy_codec.h"

namespace furrow::pipeline {
namespace {

using namespace entropy;

constexpr uint32_t kShares = 1u << kShareBits;

struct Table {
  std::array<uint32_t, 16> uses{}, first{}, share{};

  // Shares of what is used are near its part of all uses and at least one.
  void divide(uint32_t symbols) {
    uint64_t all = 0, left = kShares;
    uint32_t used = 0;
    for (uint32_t s = 0; s < symbols; ++s) {
      all += uses[s];
      used += uses[s] > 0;
    }
    for (uint32_t s = 0; s < symbols; ++s) {
      if (uses[s] == 0) continue;
      share[s] = static_cast<uint32_t>(std::max<uint64_t>(1, uses[s] * uint64_t{kShares - used} / all));
      left -= share[s];
    }
    if (all > 0)
      share[static_cast<size_t>(std::max_element(uses.begin(), uses.end()) - uses.begin())] +=
          static_cast<uint32_t>(left);
    for (uint32_t s = 1; s < symbols; ++s) first[s] = first[s - 1] + share[s - 1];
  }

  void write(std::vector<uint8_t>& out, uint32_t symbols) const {
    uint32_t listed = symbols;
    while (listed > 0 && share[listed - 1] == 0) --listed;
    out.push_back(static_cast<uint8_t>(listed));
    for (uint32_t s = 0; s < listed; ++s) {
      out.push_back(static_cast<uint8_t>(share[s] < 128 ? share[s] : (share[s] & 127) | 128));
      if (share[s] >= 128) out.push_back(static_cast<uint8_t>(share[s] >> 7));
    }
  }
};

// Written from the end to the beginning, as states come back in the order opposite to the one they went in.
class Writer {
 public:
  void symbol(size_t state, const Table& table, uint32_t s) {
    uint32_t& x = states_[state];
    spill(x, uint64_t{table.share[s]} << (32 - kShareBits));
    x = (x / table.share[s] << kShareBits) + x % table.share[s] + table.first[s];
  }

  void bits(size_t state, uint32_t value, uint32_t count) {
    uint32_t& x = states_[state];
    spill(x, uint64_t{1} << (32 - count));
    x = x << count | value;
  }

  void append(std::vector<uint8_t>& out) const {
    for (uint32_t x : states_)
      for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<uint8_t>(x >> shift));
    for (size_t i = words_.size(); i-- > 0;) {
      out.push_back(static_cast<uint8_t>(words_[i]));
      out.push_back(static_cast<uint8_t>(words_[i] >> 8));
    }
  }

 private:
  void spill(uint32_t& x, uint64_t limit) {
    if (x < limit) return;
    words_.push_back(static_cast<uint16_t>(x));
    x >>= 16;
  }

  std::array<uint32_t, kStates> states_ = [] {
    std::array<uint32_t, kStates> least;
    least.fill(kLeastState);
    return least;
  }();
  std::vector<uint16_t> words_;
};

}  // namespace

std::vector<uint8_t> encodeEntropyStream(const uint8_t* data, size_t count, size_t stride) {
  std::vector<uint8_t> out(data, data + stride);
  std::vector<size_t> planes;  // the bytes of an element that change
  out.resize(stride + (stride + 7) / 8);
  for (size_t k = 0; k < stride; ++k)
    for (size_t i = 1; i < count; ++i)
      if (data[i * stride + k] != data[k]) {
        out[stride + k / 8] |= static_cast<uint8_t>(1u << (k % 8));
        planes.push_back(k);
        break;
      }

  // Differences and widths of every group, plane by plane.
  const size_t groups = (count + kGroup - 1) / kGroup;
  std::vector<std::array<uint8_t, kGroup>> differences(groups * planes.size());
  std::vector<uint8_t> widths(differences.size());
  std::array<Table, kTables> tables;
  for (size_t g = 0; g < groups; ++g)
    for (size_t p = 0; p < planes.size(); ++p) {
      const size_t at = g * planes.size() + p;
      unsigned all = 0;
      for (size_t i = 0; i < std::min(kGroup, count - g * kGroup); ++i) {
        const size_t element = g * kGroup + i;
        const uint8_t before = data[(element > 0 ? element - 1 : 0) * stride + planes[p]];
        const auto d = static_cast<int8_t>(data[element * stride + planes[p]] - before);
        differences[at][i] = static_cast<uint8_t>(d * 2 ^ (d < 0 ? -1 : 0));
        all |= differences[at][i];
      }
      const auto width = static_cast<uint32_t>(std::bit_width(all));
      widths[at] = static_cast<uint8_t>(width);
      ++tables[g > 0 ? widths[at - planes.size()] : 0].uses[width];
      for (size_t i = 0; width > 0 && i < kGroup; ++i)
        ++tables[tableOf(width)].uses[differences[at][i] >> lowBits(width)];
    }
  for (uint32_t t = 0; t < kTables; ++t) {
    tables[t].divide(symbolsOf(t));
    tables[t].write(out, symbolsOf(t));
  }

  Writer writer;
  for (size_t at = widths.size(); at-- > 0;) {
    const uint32_t width = widths[at], low = width > 0 ? lowBits(width) : 0;
    for (size_t i = kGroup; width > 0 && i-- > 0;) {
      if (low > 0) writer.bits(i % kStates, differences[at][i] & ((1u << low) - 1), low);
      writer.symbol(i % kStates, tables[tableOf(width)], differences[at][i] >> low);
    }
    writer.symbol(0, tables[at >= planes.size() ? widths[at - planes.size()] : 0], width);
  }
  writer.append(out);
  return out;
}

}  // namespace furrow::pipeline
