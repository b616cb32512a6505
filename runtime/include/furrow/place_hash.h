#pragma once

// The perfect spatial hash: from a rest position of the SOURCE mesh to its place, in O(1), so that an engine
// whose importer reordered, split or merged the vertices binds its own buffers to the asset's points.

#include <cstddef>
#include <optional>
#include <span>

#include "furrow/status.h"
#include "furrow/types.h"

namespace furrow {

// Reads the hash section of an asset (AssetView::place_hash): a minimal perfect hash that maps the n places
// to [0, n) one to one, in under 4 bits a place, beside a 16-bit check value of each place. Owns nothing and
// allocates nothing; any number of threads may read one.
//
// Section layout, little endian: docs/format.md.
class PlaceHash {
 public:
  // Checks every count and index of the section. kBadData if it is not sound; the hash is then empty.
  // `section` needs no alignment and must outlive the hash.
  Status open(std::span<const std::byte> section);

  uint32_t placeCount() const { return place_count_; }

  // The place, < placeCount(), at exactly this position (-0 equals 0). Where no vertex of the source lay,
  // nothing, but for a chance of 2^-16 a query: then some place, anywhere. Who asks about strangers compares
  // the position with the place's, as BindJob does, which leaves no chance worth naming.
  std::optional<uint32_t> find(Float3 position) const;

 private:
  const std::byte* pilots_ = nullptr;
  const std::byte* spill_ = nullptr;
  const std::byte* checks_ = nullptr;
  uint32_t place_count_ = 0;
  uint32_t bucket_count_ = 0;
  uint32_t slot_count_ = 0;
  uint32_t seed_ = 0;
};

}  // namespace furrow
