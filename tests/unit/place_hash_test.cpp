#include "furrow/place_hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <set>
#include <stdexcept>
#include <tuple>

#include "pipeline/bake/perfect_hash.h"
#include "runtime/src/place_hash_format.h"

namespace furrow {
namespace {

using pipeline::buildPlaceHash;
using pipeline::BuiltPlaceHash;

Float3 asFloat3(const glm::vec3& p) {
  return {p.x, p.y, p.z};
}

std::vector<glm::vec3> randomPlaces(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-23f - 1.0f; };
  std::set<std::tuple<float, float, float>> seen;
  std::vector<glm::vec3> places;
  while (places.size() < count) {
    glm::vec3 p{unit(), unit(), unit()};
    if (seen.emplace(p.x, p.y, p.z).second) places.push_back(p);
  }
  return places;
}

// The worst case for a weak hash: few different coordinates, all with few significant bits.
std::vector<glm::vec3> gridPlaces(int side) {
  std::vector<glm::vec3> places;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) places.emplace_back(x, y - side / 2, 0.25f * static_cast<float>(z));
  return places;
}

void expectBijection(const std::vector<glm::vec3>& places) {
  BuiltPlaceHash built = buildPlaceHash(places);
  PlaceHash hash;
  Status status = hash.open(built.section);
  ASSERT_TRUE(status.ok()) << status.message;
  ASSERT_EQ(hash.placeCount(), places.size());
  ASSERT_EQ(built.slots.size(), places.size());
  std::vector<bool> taken(places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    std::optional<uint32_t> place = hash.find(asFloat3(places[i]));
    ASSERT_TRUE(place.has_value()) << "place " << i;
    ASSERT_EQ(*place, built.slots[i]) << "place " << i;
    ASSERT_LT(*place, places.size());
    ASSERT_FALSE(taken[*place]) << "slot " << *place << " is given twice";
    taken[*place] = true;
  }
}

TEST(PlaceHash, IsABijectionOnAnyCount) {
  std::vector<size_t> counts = {1000, 4097, 30011};
  for (size_t count = 0; count < 200; ++count) counts.push_back(count);
  for (size_t count : counts) {
    SCOPED_TRACE(count);
    expectBijection(randomPlaces(count, static_cast<uint32_t>(count)));
  }
}

TEST(PlaceHash, IsABijectionOnAMillionRandomPlaces) {
  expectBijection(randomPlaces(1000000, 7));
}

TEST(PlaceHash, IsABijectionOnAMillionGridPlaces) {
  expectBijection(gridPlaces(100));
}

TEST(PlaceHash, TakesAtMostFourBitsAPlaceBesideTheChecks) {
  for (const auto& places : {randomPlaces(1000, 1), randomPlaces(100000, 2), gridPlaces(100)}) {
    double bits =
        8.0 * static_cast<double>(buildPlaceHash(places).section.size()) / static_cast<double>(places.size());
    EXPECT_LE(bits, 16.0 + 4.0) << places.size() << " places";
  }
}

TEST(PlaceHash, RefusesStrangers) {
  std::vector<glm::vec3> places = randomPlaces(1000, 3);
  BuiltPlaceHash built = buildPlaceHash(places);
  PlaceHash hash;
  ASSERT_TRUE(hash.open(built.section).ok());
  int near = 0, far = 0;
  for (const glm::vec3& p : places) {  // the nearest strangers there are: one bit off
    near += hash.find({std::nextafter(p.x, 2.0f), p.y, p.z}).has_value();
    near += hash.find({p.x, std::nextafter(p.y, 2.0f), p.z}).has_value();
    near += hash.find({p.x, p.y, std::nextafter(p.z, 2.0f)}).has_value();
    near += hash.find({p.y, p.x, p.z}).has_value();
  }
  std::mt19937 random(4);
  const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-23f - 1.0f; };
  for (int i = 0; i < 1000000; ++i) far += hash.find({unit(), unit(), unit()}).has_value();
  EXPECT_LE(near, 1);  // of 4000; the chance is 2^-16 each
  EXPECT_NEAR(far, 1e6 / 65536.0, 4.0 * std::sqrt(1e6 / 65536.0));
  EXPECT_FALSE(hash.find({NAN, INFINITY, 0.0f}));
}

TEST(PlaceHash, MinusZeroIsZero) {
  std::vector<glm::vec3> places = {{0.0f, 1.0f, -0.0f}, {-0.0f, 2.0f, 0.0f}};
  BuiltPlaceHash built = buildPlaceHash(places);
  PlaceHash hash;
  ASSERT_TRUE(hash.open(built.section).ok());
  for (float x : {0.0f, -0.0f})
    for (float z : {0.0f, -0.0f}) {
      EXPECT_EQ(hash.find({x, 1.0f, z}), built.slots[0]);
      EXPECT_EQ(hash.find({x, 2.0f, z}), built.slots[1]);
    }
}

TEST(PlaceHash, BuilderRefusesEqualPositions) {
  std::vector<glm::vec3> places = randomPlaces(5000, 5);
  places.push_back(places[1234]);
  EXPECT_THROW(buildPlaceHash(places), std::invalid_argument);
  std::vector<glm::vec3> zeros = {{0.0f, 0.0f, 0.0f}, {-0.0f, 0.0f, 0.0f}};
  EXPECT_THROW(buildPlaceHash(zeros), std::invalid_argument);
  EXPECT_THROW(buildPlaceHash(std::vector<glm::vec3>(10000)), std::invalid_argument);
}

TEST(PlaceHash, SamePlacesGiveTheSameBytes) {
  std::vector<glm::vec3> places = randomPlaces(20000, 6);
  BuiltPlaceHash a = buildPlaceHash(places), b = buildPlaceHash(places);
  EXPECT_EQ(a.section, b.section);
  EXPECT_EQ(a.slots, b.slots);
}

// The bytes of format version 2. If they change, assets cooked before no longer bind: bump kVersion instead.
TEST(PlaceHash, ReadsASectionOfVersion2) {
  std::vector<glm::vec3> places = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.5f, -2.0f, 1e-3f}};
  const uint16_t section[] = {0x4c46, 0x4850, 2, 0,      3, 0,      2,      0,     3,
                              0,      0,      0, 0x0203, 0, 0x2f23, 0x1fcd, 0x8968};
  const uint32_t slots[] = {2, 0, 1};
  PlaceHash hash;
  Status status = hash.open(std::as_bytes(std::span(section)));
  ASSERT_TRUE(status.ok()) << status.message;
  for (size_t i = 0; i < places.size(); ++i) EXPECT_EQ(hash.find(asFloat3(places[i])), slots[i]);
  BuiltPlaceHash built = buildPlaceHash(places);
  ASSERT_EQ(built.section.size(), sizeof(section));
  EXPECT_EQ(std::memcmp(built.section.data(), section, sizeof(section)), 0);
}

TEST(PlaceHash, ASlotBeyondTheLastPlaceIsRefused) {
  std::vector<std::byte> section = buildPlaceHash(randomPlaces(300, 8)).section;
  place_hash::Header header;
  std::memcpy(&header, section.data(), sizeof(header));
  ASSERT_GT(header.slot_count, header.place_count);
  for (const uint32_t slot : {header.place_count - 1, header.place_count}) {
    std::memcpy(section.data() + header.spillBegin(), &slot, sizeof(slot));
    EXPECT_EQ(PlaceHash().open(section).ok(), slot < header.place_count);
  }
}

TEST(PlaceHash, EveryTruncationAndAnExtraByteAreRefused) {
  std::vector<std::byte> section = buildPlaceHash(randomPlaces(300, 8)).section;
  for (size_t size = 0; size < section.size(); ++size) {
    std::vector<std::byte> cut(section.begin(),
                               section.begin() + static_cast<std::ptrdiff_t>(size));  // its own, for ASan
    PlaceHash hash;
    Status status = hash.open(cut);
    ASSERT_EQ(status.code, StatusCode::kBadData) << size << " bytes";
    ASSERT_STRNE(status.message, "");
    ASSERT_EQ(hash.placeCount(), 0u);
    ASSERT_FALSE(hash.find({}));
  }
  section.push_back(std::byte{0});
  EXPECT_EQ(PlaceHash().open(section).code, StatusCode::kBadData);
}

TEST(PlaceHash, EveryFlippedBitIsRefusedOrStaysInRange) {
  std::vector<glm::vec3> places = randomPlaces(40, 9);
  const std::vector<std::byte> section = buildPlaceHash(places).section;
  for (size_t bit = 0; bit < section.size() * 8; ++bit) {
    std::vector<std::byte> flipped = section;
    flipped[bit / 8] ^= std::byte{1} << (bit % 8);
    PlaceHash hash;
    bool opened = hash.open(flipped).ok();
    EXPECT_FALSE(opened && bit < 3 * 32) << "magic, version and the number of places, bit " << bit;
    EXPECT_FALSE(opened && bit / 32 == 4) << "the number of slots, bit " << bit;
    if (!opened) continue;
    for (const glm::vec3& p : places)
      if (auto place = hash.find(asFloat3(p))) {
        ASSERT_LT(*place, hash.placeCount());
      }
  }
}

TEST(PlaceHash, RandomBytesNeverCrash) {
  std::mt19937 random(10);
  std::vector<glm::vec3> places = randomPlaces(60, 11);
  const std::vector<std::byte> section = buildPlaceHash(places).section;
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::byte> noisy = section;  // counts, pilots and spill, with magic and version left alone
    for (uint32_t writes = 1 + random() % 4; writes > 0; --writes)
      noisy[8 + random() % 48] = static_cast<std::byte>(random() % (random() % 2 ? 256 : 4));
    PlaceHash hash;
    if (!hash.open(noisy).ok()) continue;
    for (const glm::vec3& p : places)
      if (auto place = hash.find(asFloat3(p))) {
        ASSERT_LT(*place, hash.placeCount());
      }
  }
}

TEST(PlaceHash, ReadsAtAnyAlignment) {
  std::vector<glm::vec3> places = randomPlaces(1000, 12);
  BuiltPlaceHash built = buildPlaceHash(places);
  for (size_t shift = 1; shift < 8; ++shift) {
    std::vector<std::byte> moved(built.section.size() + shift);
    std::memcpy(moved.data() + shift, built.section.data(), built.section.size());
    PlaceHash hash;
    ASSERT_TRUE(hash.open(std::span(moved).subspan(shift)).ok());
    for (size_t i = 0; i < places.size(); ++i) ASSERT_EQ(hash.find(asFloat3(places[i])), built.slots[i]);
  }
}

TEST(PlaceHash, ANewerVersionIsNamed) {
  std::vector<std::byte> section = buildPlaceHash(randomPlaces(3, 13)).section;
  section[4] = std::byte{3};
  Status status = PlaceHash().open(section);
  EXPECT_EQ(status.code, StatusCode::kUnsupportedVersion);
  EXPECT_STREQ(status.message, "place hash: version 3, this build reads version 2");
}

}  // namespace
}  // namespace furrow
