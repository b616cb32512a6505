#include "pipeline/bake/perfect_hash.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <utility>

#include "runtime/src/place_hash_format.h"

namespace furrow::pipeline {

using namespace place_hash;

namespace {

constexpr uint32_t kFree = 0xffffffffu;
constexpr size_t kAhead = 8;  // buckets whose hashes are fetched before their turn

Key keyOf(const glm::vec3& p) {
  return Key(Float3{p.x, p.y, p.z});
}

// The hashes bucket by bucket.
struct Buckets {
  std::vector<uint32_t> begins;  // buckets + 1
  std::vector<uint64_t> hashes;

  Buckets(const std::vector<uint64_t>& unsorted, uint32_t count)
      : begins(count + size_t{1}), hashes(unsorted.size()) {
    for (uint64_t hash : unsorted) ++begins[bucketOf(hash, count) + size_t{1}];
    for (size_t b = 0; b < count; ++b) begins[b + 1] += begins[b];
    std::vector<uint32_t> next(begins.begin(), begins.end() - 1);
    for (uint64_t hash : unsorted) hashes[next[bucketOf(hash, count)]++] = hash;
  }
  uint32_t count() const { return static_cast<uint32_t>(begins.size() - 1); }
  uint32_t size(uint32_t bucket) const { return begins[bucket + size_t{1}] - begins[bucket]; }
  std::span<const uint64_t> operator[](uint32_t bucket) const {
    return std::span(hashes).subspan(begins[bucket], size(bucket));
  }
};

bool hasEqualHashes(Buckets& buckets) {  // sorts each
  for (uint32_t b = 0; b < buckets.count(); ++b) {
    auto first = buckets.hashes.begin() + buckets.begins[b],
         last = buckets.hashes.begin() + buckets.begins[b + size_t{1}];
    std::sort(first, last);
    if (std::adjacent_find(first, last) != last) return true;
  }
  return false;
}

bool hasEqualPlaces(std::span<const glm::vec3> places) {
  std::vector<Key> keys;
  keys.reserve(places.size());
  for (const glm::vec3& p : places) keys.push_back(keyOf(p));
  std::sort(keys.begin(), keys.end());
  return std::adjacent_find(keys.begin(), keys.end()) != keys.end();
}

// Finds a pilot for every bucket, so that no two hashes fall on one slot. The largest buckets choose first;
// one that finds no free room takes that of the buckets whose loss costs least, and these choose again.
class PilotSearch {
 public:
  PilotSearch(const Buckets& buckets, uint32_t slot_count)
      : buckets_(buckets),
        slot_count_(slot_count),
        pilots_(buckets.count()),
        owner_(slot_count, kFree),
        taken_(slot_count / 64 + 1) {}

  // False if the search went round in circles.
  bool run() {
    const std::vector<uint32_t> order = largestFirst();
    uint64_t evictions_left = 1000 + 10 * uint64_t{buckets_.count()};
    for (size_t i = 0; i < order.size(); ++i) {
      const uint32_t bucket = order[i];
      if (buckets_.size(bucket) == 0) break;
      if (i + kAhead < order.size())
        __builtin_prefetch(buckets_.hashes.data() + buckets_.begins[order[i + kAhead]]);
      if (placeInFreeRoom(bucket)) continue;
      evicted_.push({buckets_.size(bucket), bucket});
      while (!evicted_.empty()) {
        uint32_t b = evicted_.top().second;
        evicted_.pop();
        if (placeInFreeRoom(b)) continue;
        if (evictions_left-- == 0 || !placeByForce(b)) return false;
      }
    }
    return true;
  }

  const std::vector<uint8_t>& pilots() const { return pilots_; }
  bool taken(uint32_t slot) const { return owner_[slot] != kFree; }

 private:
  std::vector<uint32_t> largestFirst() const {
    uint32_t largest = 0;
    for (uint32_t b = 0; b < buckets_.count(); ++b) largest = std::max(largest, buckets_.size(b));
    std::vector<uint32_t> begins(largest + size_t{2}), order(buckets_.count());
    for (uint32_t b = 0; b < buckets_.count(); ++b) ++begins[largest - buckets_.size(b) + size_t{1}];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    for (uint32_t b = 0; b < buckets_.count(); ++b) order[begins[largest - buckets_.size(b)]++] = b;
    return order;
  }

  bool isTaken(uint32_t slot) const { return (taken_[slot / 64] >> (slot % 64) & 1) != 0; }

  // Into slots_; false if two of the bucket's own hashes meet.
  bool findSlots(uint32_t bucket, uint32_t pilot) {
    slots_.clear();
    for (uint64_t hash : buckets_[bucket]) slots_.push_back(slotOf(hash, pilot, slot_count_));
    for (size_t i = 1; i < slots_.size(); ++i)
      for (size_t j = 0; j < i; ++j)
        if (slots_[i] == slots_[j]) return false;
    return true;
  }

  void take(uint32_t bucket, uint32_t pilot) {
    pilots_[bucket] = static_cast<uint8_t>(pilot);
    for (uint32_t slot : slots_) {
      owner_[slot] = bucket;
      taken_[slot / 64] |= uint64_t{1} << (slot % 64);
    }
  }

  void evict(uint32_t bucket) {
    for (uint64_t hash : buckets_[bucket]) {
      uint32_t slot = slotOf(hash, pilots_[bucket], slot_count_);
      owner_[slot] = kFree;
      taken_[slot / 64] &= ~(uint64_t{1} << (slot % 64));
    }
    evicted_.push({buckets_.size(bucket), bucket});
  }

  bool placeInFreeRoom(uint32_t bucket) {
    std::span<const uint64_t> hashes = buckets_[bucket];
    for (uint32_t pilot = 0; pilot < kPilots; ++pilot) {
      bool free = std::none_of(hashes.begin(), hashes.end(),
                               [&](uint64_t hash) { return isTaken(slotOf(hash, pilot, slot_count_)); });
      if (free && findSlots(bucket, pilot)) {
        take(bucket, pilot);
        return true;
      }
    }
    return false;
  }

  bool placeByForce(uint32_t bucket) {
    uint64_t best_cost = std::numeric_limits<uint64_t>::max();
    uint32_t best_pilot = 0;
    // Elsewhere every time, so that two buckets do not evict each other for ever.
    const uint32_t first = 89 * forced_++;
    for (uint32_t i = 0; i < kPilots; ++i) {
      uint32_t pilot = (first + i) % kPilots;
      if (!findSlots(bucket, pilot)) continue;
      uint64_t cost = 0;
      for (uint32_t slot : slots_) {
        uint32_t owner = owner_[slot];
        if (owner == kFree) continue;
        uint64_t size = buckets_.size(owner);
        bool recent = std::find(recent_.begin(), recent_.end(), owner) != recent_.end();
        cost += recent ? uint64_t{1} << 40 : size * size;
      }
      if (cost < best_cost) {
        best_cost = cost;
        best_pilot = pilot;
      }
    }
    if (best_cost == std::numeric_limits<uint64_t>::max()) return false;
    findSlots(bucket, best_pilot);
    for (uint32_t slot : slots_)
      if (owner_[slot] != kFree) evict(owner_[slot]);
    take(bucket, best_pilot);
    recent_[forced_ % recent_.size()] = bucket;
    return true;
  }

  const Buckets& buckets_;
  uint32_t slot_count_;
  std::vector<uint8_t> pilots_;
  std::vector<uint32_t> owner_;  // slot -> bucket
  std::vector<uint64_t> taken_;  // a bit a slot: owner_ in a fraction of the memory
  std::vector<uint32_t> slots_;
  std::priority_queue<std::pair<uint32_t, uint32_t>> evicted_;  // size, bucket
  std::array<uint32_t, 16> recent_ = [] {
    std::array<uint32_t, 16> none;
    none.fill(kFree);
    return none;
  }();
  uint32_t forced_ = 0;
};

// A place for every slot past the last place: the lowest place whose own slot is empty.
std::vector<uint32_t> findSpill(const PilotSearch& search, uint32_t place_count, uint32_t slot_count) {
  std::vector<uint32_t> spill;
  uint32_t empty = 0;
  for (uint32_t slot = place_count; slot < slot_count; ++slot) {
    if (!search.taken(slot)) {
      spill.push_back(0);  // no place falls on it; a stranger that does is refused by the check
      continue;
    }
    while (search.taken(empty)) ++empty;
    spill.push_back(empty++);
  }
  return spill;
}

}  // namespace

BuiltPlaceHash buildPlaceHash(std::span<const glm::vec3> places) {
  if (places.size() > kMaxPlaces) throw std::invalid_argument("place hash: more than 2^30 places");
  uint32_t count = static_cast<uint32_t>(places.size());
  Header header{kMagic, kVersion, count, count / 3 + (count != 0), count + count / 50, 0};

  std::vector<uint64_t> hashes(count);
  for (;; ++header.seed) {
    for (uint32_t i = 0; i < count; ++i) hashes[i] = hashOf(keyOf(places[i]), header.seed);
    Buckets buckets(hashes, header.bucket_count);
    if (hasEqualHashes(buckets)) {
      if (hasEqualPlaces(places)) throw std::invalid_argument("place hash: two places at one position");
      continue;
    }
    PilotSearch search(buckets, header.slot_count);
    if (!search.run()) continue;

    BuiltPlaceHash built;
    built.section.resize(header.size());
    auto write = [&](uint64_t offset, const auto& values) {
      if (!values.empty())
        std::memcpy(built.section.data() + offset, values.data(), values.size() * sizeof(values[0]));
    };
    std::vector<uint32_t> spill = findSpill(search, count, header.slot_count);
    std::vector<uint16_t> checks(count);
    built.slots.resize(count);
    for (uint32_t i = 0; i < count; ++i) {
      uint32_t slot =
          slotOf(hashes[i], search.pilots()[bucketOf(hashes[i], header.bucket_count)], header.slot_count);
      built.slots[i] = slot < count ? slot : spill[slot - count];
      checks[built.slots[i]] = checkOf(hashes[i]);
    }
    std::memcpy(built.section.data(), &header, sizeof(Header));
    write(sizeof(Header), search.pilots());
    write(header.spillBegin(), spill);
    write(header.checksBegin(), checks);
    return built;
  }
}

}  // namespace furrow::pipeline
