#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace furrow::pipeline {

// An open-addressed table of at most `most` indices below `most`. What an index leaves free of its word holds
// bits of the hash, its tag, so that nearly every look at what an index leads to is at the right one.
class IndexTable {
 public:
  static constexpr uint32_t kFree = 0xffffffffu;
  static constexpr size_t kBlock = 64;  // hashes to prefetch before the first of them is looked for

  explicit IndexTable(size_t most)
      : index_mask_(std::bit_ceil(static_cast<uint32_t>(most) + 1) - 1),
        slot_mask_(std::bit_ceil(most + most / 2 + 1) - 1),
        entries_(slot_mask_ + 1, kFree) {}

  void prefetch(uint64_t hash) const { __builtin_prefetch(&entries_[hash >> 32 & slot_mask_], 1); }

  // Goes to the first entry with this hash's tag that `accept` takes, or to a free one.
  template <typename Accept>
  uint32_t* find(uint64_t hash, Accept accept) {
    for (size_t slot = hash >> 32 & slot_mask_;; slot = (slot + 1) & slot_mask_) {
      uint32_t& entry = entries_[slot];
      if (entry == kFree || (((entry ^ hash) & tagMask()) == 0 && accept(indexOf(entry)))) return &entry;
    }
  }

  uint32_t entryOf(uint64_t hash, size_t index) const {
    return (static_cast<uint32_t>(hash) & tagMask()) | static_cast<uint32_t>(index);
  }
  uint32_t indexOf(uint32_t entry) const { return entry & index_mask_; }

 private:
  uint32_t tagMask() const { return ~index_mask_; }

  uint32_t index_mask_;
  size_t slot_mask_;
  std::vector<uint32_t> entries_;
};

}  // namespace furrow::pipeline
