#pragma once

// The perfect spatial hash: from a rest position of the SOURCE mesh to its place, in O(1), so that an engine
// whose importer reordered, split or merged the vertices binds its own buffers to the asset's points.

#include <optional>
#include <span>

#include "furrow/status.h"
#include "furrow/types.h"

namespace furrow {

// Reads the hash section of an asset (AssetView::place_hash). Owns nothing; any number of threads.
//
// Section layout, little endian: documented in docs/format.md.
class PlaceHash {
 public:
  // Checks every count of the section. kBadData if it is not sound.
  Status open(std::span<const std::byte> section);

  uint32_t placeCount() const;

  // The place at exactly this position (-0 equals 0), or nothing if no vertex of the source lay there, but
  // for a chance of 2^-32 a query.
  std::optional<uint32_t> find(Float3 position) const;

 private:
  std::span<const std::byte> section_;
};

}  // namespace furrow
