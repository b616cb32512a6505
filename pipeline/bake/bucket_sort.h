#pragma once

// Sorting in linear time where a part of the key is a number that few share, such as a point of a mesh.

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace furrow::pipeline {

// The numbers below `count` by bucketOf(number), which is below `buckets`, and in a bucket by less(a, b).
template <class BucketOf, class Less>
std::vector<uint32_t> bucketSorted(uint32_t count, uint32_t buckets, const BucketOf& bucketOf,
                                   const Less& less) {
  std::vector<uint32_t> begins(buckets + size_t{1}, 0), sorted(count);
  for (uint32_t i = 0; i < count; ++i) ++begins[bucketOf(i)];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  for (uint32_t i = 0; i < count; ++i) sorted[--begins[bucketOf(i)]] = i;
  for (size_t b = 0; b < buckets; ++b)
    std::sort(sorted.begin() + begins[b], sorted.begin() + begins[b + 1], less);
  return sorted;
}

// The sides below `count` by ends(side), a pair of points below `points`, and among equal ones by number:
// those of one edge lie together.
template <class Ends>
std::vector<uint32_t> sidesByEnds(uint32_t count, uint32_t points, const Ends& ends) {
  return bucketSorted(
      count, points, [&](uint32_t side) { return ends(side).first; },
      [&](uint32_t a, uint32_t b) {
        const uint32_t to_a = ends(a).second, to_b = ends(b).second;
        return to_a != to_b ? to_a < to_b : a < b;
      });
}

}  // namespace furrow::pipeline
