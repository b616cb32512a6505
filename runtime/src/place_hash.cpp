#include "furrow/place_hash.h"

#include <cstring>

#include "place_hash_format.h"

namespace furrow {

using namespace place_hash;

namespace {

template <class T>
T read(const std::byte* base, size_t index = 0) {
  T value;
  std::memcpy(&value, base + index * sizeof(T), sizeof(T));
  return value;
}

Status broken(const char* what) {
  return Status::error(StatusCode::kBadData, "place hash: %s", what);
}

}  // namespace

Status PlaceHash::open(std::span<const std::byte> section) {
  *this = {};
  if (section.size() < sizeof(Header)) return broken("shorter than its header");
  Header header = read<Header>(section.data());
  if (header.magic != kMagic) return broken("does not begin with FLPH");
  if (header.version != kVersion)
    return Status::error(StatusCode::kUnsupportedVersion,
                         "place hash: version %u, this build reads version %u",
                         static_cast<unsigned>(header.version), static_cast<unsigned>(kVersion));
  if (header.place_count > kMaxPlaces) return broken("more places than the format has");
  if (header.slot_count < header.place_count) return broken("fewer slots than places");
  if (header.place_count != 0 && header.bucket_count == 0) return broken("places but no buckets");
  if (header.size() != section.size()) return broken("its size is not that of its counts");

  const std::byte* spill = section.data() + header.spillBegin();
  for (uint32_t i = 0; i < header.slot_count - header.place_count; ++i)
    if (read<uint32_t>(spill, i) >= header.place_count) return broken("a slot leads to no place");

  pilots_ = section.data() + sizeof(Header);
  spill_ = spill;
  checks_ = section.data() + header.checksBegin();
  place_count_ = header.place_count;
  bucket_count_ = header.bucket_count;
  slot_count_ = header.slot_count;
  seed_ = header.seed;
  return {};
}

std::optional<uint32_t> PlaceHash::find(Float3 position) const {
  if (place_count_ == 0) return std::nullopt;
  uint64_t hash = hashOf(Key(position), seed_);
  uint32_t place = slotOf(hash, static_cast<uint8_t>(pilots_[bucketOf(hash, bucket_count_)]), slot_count_);
  if (place >= place_count_) place = read<uint32_t>(spill_, place - place_count_);
  if (read<uint16_t>(checks_, place) != checkOf(hash)) return std::nullopt;
  return place;
}

}  // namespace furrow
