#include "entropy_codec.h"

#include <cstring>
#include <utility>
#include <vector>

namespace furrow {
namespace {

using namespace entropy;

constexpr uint32_t kShares = 1u << kShareBits;

struct Table {
  uint8_t symbol[kShares];  // a share's
  uint16_t first[16], share[16];
};

class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : at_(bytes.data()), end_(bytes.data() + bytes.size()) {}

  // Null where there are not so many bytes.
  const uint8_t* take(size_t count) {
    if (static_cast<size_t>(end_ - at_) < count) return nullptr;
    return std::exchange(at_, at_ + count);
  }

  // How many shares are listed, then each of them in one byte or, from 128, in two. A table without any is
  // not used.
  bool read(Table& table, uint32_t symbols) {
    const uint8_t* listed = take(1);
    if (!listed || *listed > symbols) return false;
    uint32_t sum = 0;
    for (uint32_t s = 0; s < *listed; ++s) {
      const uint8_t* low = take(1);
      const uint8_t* high = low && *low >= 128 ? take(1) : nullptr;
      if (!low || (*low >= 128 && !high)) return false;
      const uint32_t share = (*low & 127u) | (high ? uint32_t{*high} << 7 : 0u);
      if (share > kShares - sum) return false;
      table.first[s] = static_cast<uint16_t>(sum);
      table.share[s] = static_cast<uint16_t>(share);
      std::memset(table.symbol + sum, static_cast<int>(s), share);
      sum += share;
    }
    return sum == (*listed > 0 ? kShares : 0u);
  }

  bool start(uint32_t (&states)[kStates]) {
    const uint8_t* bytes = take(4 * kStates);
    if (bytes) std::memcpy(states, bytes, 4 * kStates);
    return bytes;
  }

  uint32_t symbol(uint32_t& state, const Table& table) {
    const uint32_t slot = state & (kShares - 1), s = table.symbol[slot];
    state = table.share[s] * (state >> kShareBits) + slot - table.first[s];
    refill(state);
    return s;
  }

  uint32_t bits(uint32_t& state, uint32_t count) {
    const uint32_t value = state & ((1u << count) - 1);
    state >>= count;
    refill(state);
    return value;
  }

  bool atEnd() const { return at_ == end_; }

 private:
  void refill(uint32_t& state) {
    if (state >= kLeastState || end_ - at_ < 2) return;
    state = state << 16 | at_[0] | uint32_t{at_[1]} << 8;
    at_ += 2;
  }

  const uint8_t* at_;
  const uint8_t* end_;
};

}  // namespace

bool decodeEntropyStream(std::span<const uint8_t> bytes, size_t count, size_t stride, uint8_t* out) {
  if (stride == 0 || stride > 256) return false;
  Reader reader(bytes);
  const uint8_t* first = reader.take(stride);
  const uint8_t* changes = reader.take((stride + 7) / 8);
  if (!first || !changes) return false;
  std::vector<Table> tables(kTables);  // all zero: a table that is not used gives symbol 0 and an end
  for (uint32_t t = 0; t < kTables; ++t)
    if (!reader.read(tables[t], symbolsOf(t))) return false;
  uint32_t states[kStates];
  if (!reader.start(states)) return false;

  uint8_t last[256], width_before[256] = {};
  std::memcpy(last, first, stride);
  for (size_t begin = 0; begin < count; begin += kGroup, out += kGroup * stride) {
    const size_t elements = std::min(kGroup, count - begin);
    for (size_t k = 0; k < stride; ++k) {
      uint8_t value = last[k];
      const uint32_t width =
          changes[k / 8] >> (k % 8) & 1 ? reader.symbol(states[0], tables[width_before[k]]) : 0;
      width_before[k] = static_cast<uint8_t>(width);
      if (width == 0) {
        for (size_t i = 0; i < elements; ++i) out[i * stride + k] = value;
        continue;
      }
      const Table& table = tables[tableOf(width)];
      const uint32_t low = lowBits(width);
      uint8_t values[kGroup];
      for (size_t i = 0; i < kGroup; i += kStates)
        for (size_t s = 0; s < kStates; ++s) {
          uint32_t d = reader.symbol(states[s], table);
          if (low > 0) d = d << low | reader.bits(states[s], low);
          values[i + s] = value = static_cast<uint8_t>(value + (d & 1 ? ~(d >> 1) : d >> 1));  // zigzag
        }
      for (size_t i = 0; i < elements; ++i) out[i * stride + k] = values[i];
      last[k] = value;
    }
  }
  return reader.atEnd() &&
         std::all_of(states, states + kStates, [](uint32_t state) { return state == kLeastState; });
}

}  // namespace furrow
