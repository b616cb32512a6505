// Stored assets of format versions: the present one loads and gives the numbers it gave when it was
// stored, every other is refused with both versions and what to do.

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string_view>
#include <vector>

#include "furrow/jobs.h"

namespace furrow::test {
namespace {

const std::filesystem::path kStored = FURROW_SOURCE_DIR "/tests/data/assets";

std::vector<std::byte> readStored(const std::string& name) {
  std::ifstream in(kStored / name, std::ios::binary);
  EXPECT_TRUE(in) << name << " is missing: cook tests/data/strip.gltf with strip.json for the new version";
  std::vector<char> bytes(std::istreambuf_iterator<char>(in), {});
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

// "v3": without operator+, about which gcc 12 warns in vain.
const std::string kPresent = std::string("v").append(std::to_string(kFormatVersion));

// The strip: 2 along x, 0.5 along y, cut into 8 x 3 quads; its target "squeeze" takes 0.6 u from x, so that
// along x, the direction of its first layer, q is 0.7^2.
TEST(StoredAssets, OfThePresentVersionGiveTheirNumbers) {
  for (const char* geometry : {"", "_raw"}) {
    SCOPED_TRACE(geometry);
    Asset asset;
    const Status status = asset.load(readStored(kPresent + geometry + ".furrow"));
    ASSERT_TRUE(status.ok()) << status.message;
    const AssetView& view = asset.view();
    ASSERT_EQ(view.vertexCount(), 36u);
    ASSERT_EQ(view.triangleCount(), 48u);
    ASSERT_EQ(view.pointCount(), 36u);
    ASSERT_EQ(view.layerCount(), 2u);
    EXPECT_EQ(view.layers[0].name, "along");
    EXPECT_EQ(view.layers[1].measure, Measure::kPrincipal);
    ASSERT_EQ(view.morphs.size(), 2u);
    EXPECT_EQ(view.morphs[0].name, "squeeze");
    ASSERT_EQ(view.drivers.size(), 1u);
    EXPECT_EQ(view.drivers[0].gain, 0.5f);
    ASSERT_EQ(view.texture_sets.size(), 1u);
    EXPECT_EQ(view.texture_sets[0].normals.width, 16u);

    std::vector<Affine> palette;
    for (const PaletteEntry& entry : view.palette) palette.push_back(entry.inverse_bind);
    palette[1].m[3] += 2.0f;  // the second joint stands at x = 2
    const float morphs[] = {1.0f, 0.0f};
    std::vector<Float3> positions(view.vertexCount());
    DeformJob{&view, palette, morphs, positions, {}, {}}.run(0, view.vertexCount());
    std::vector<float> triangle_q(view.triangleCount()), point_q(view.pointCount());
    CompressJob{&view, 0, positions, 1.0f, triangle_q}.run(0, view.triangleCount());
    SmoothJob{&view, triangle_q, point_q}.run(0, view.pointCount());
    for (const float q : point_q) EXPECT_NEAR(q, 0.49f, 1e-3f);
  }
}

// What an asset holds, by address.
class Blocks : public std::pmr::memory_resource {
 public:
  std::map<void*, size_t> held;

 private:
  void* do_allocate(size_t bytes, size_t alignment) override {
    void* block = std::pmr::new_delete_resource()->allocate(bytes, alignment);
    std::memset(block, 0, bytes);  // what lay there before
    held[block] = bytes;
    return block;
  }
  void do_deallocate(void* block, size_t bytes, size_t alignment) override {
    held.erase(block);
    std::pmr::new_delete_resource()->deallocate(block, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

TEST(StoredAssets, KeepNothingOfTheFileBesideWhatWasReadFromIt) {
  const std::vector<std::byte> file = readStored(kPresent + ".furrow");
  const std::string_view identifier = "FRRW";  // of the payload
  const auto has = [&](const char* bytes, size_t count) {
    return std::string_view(bytes, count).find(identifier) != std::string_view::npos;
  };
  ASSERT_TRUE(has(reinterpret_cast<const char*>(file.data()), file.size()));
  Blocks blocks;
  {
    Asset asset;
    ASSERT_TRUE(asset.load(file, &blocks).ok());
    EXPECT_FALSE(blocks.held.empty());
    for (const auto& [block, bytes] : blocks.held) EXPECT_FALSE(has(static_cast<const char*>(block), bytes));
  }
  EXPECT_TRUE(blocks.held.empty());
}

TEST(StoredAssets, OfEveryOtherVersionAreRefused) {
  for (const auto& entry : std::filesystem::directory_iterator(kStored)) {
    const std::string name = entry.path().stem();
    if (name == kPresent || name == kPresent + "_raw") continue;
    Asset asset;
    const Status status = asset.load(readStored(entry.path().filename()));
    EXPECT_EQ(status.code, StatusCode::kUnsupportedVersion) << name;
    const std::string version = name.substr(1, name.find('_') - 1);
    EXPECT_EQ(std::string(status.message),
              "it has format version " + version + ", this furrow reads version " + kPresent.substr(1));
    EXPECT_EQ(asset.view().vertexCount(), 0u);
  }
}

}  // namespace
}  // namespace furrow::test
