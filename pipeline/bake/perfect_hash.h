#pragma once

// Builds the minimal perfect hash from rest positions to places that furrow::PlaceHash reads
// (furrow/place_hash.h).

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace furrow::pipeline {

struct BuiltPlaceHash {
  std::vector<std::byte> section;  // what PlaceHash::open() takes
  std::vector<uint32_t> slots;     // a permutation of [0, places): find(places[i]) == slots[i]
};

// `places`: finite positions, pairwise different (-0 equals 0). The hash gives each a slot in [0,
// places.size()) of its own choosing; the cook numbers its places by slot, so that no table from slot to
// place is stored.
//
// Expected time and memory are linear in the number of places, and the same places in the same order give the
// same bytes. Throws std::invalid_argument if two positions are equal, or there are more than 2^30.
//
// Method: Groot Koerkamp, "PtrHash: minimal perfect hashing at RAM throughput" (2025), in one part: a byte
// for every bucket of 3 places on average, 2% more slots than places, 3.3 bits a place in all.
BuiltPlaceHash buildPlaceHash(std::span<const glm::vec3> places);

}  // namespace furrow::pipeline
