// integration BROW.furrow: the C++ of docs/integration.md as it stands there.

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "cpp_1_1.inc"
#include "cpp_2_1.inc"
#include "cpp_3_1.inc"

namespace {

int fail(const char* message) {
  std::fprintf(stderr, "%s\n", message);
  return 1;
}

void log(const char* message) {
  std::printf("%s\n", message);
}

// What an engine's renderer would keep of a plan.
std::map<furrow::Buffer, std::vector<std::byte>> made;
size_t recorded = 0;

void make(uint32_t id, uint64_t bytes, std::span<const std::byte> initial) {
  auto& buffer = made[furrow::Buffer(id)];
  buffer.assign(initial.begin(), initial.end());
  buffer.resize(bytes);
}

void copy(std::span<const furrow::Affine> from, std::span<std::byte> to) {
  std::memcpy(to.data(), from.data(), from.size_bytes());
}

void record(const furrow::Item& item) {
  recorded += item.kind == furrow::ItemKind::kDispatch;
}

std::vector<std::byte> readFile(const char* name) {
  std::ifstream in(name, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::byte> bytes = readFile(argc > 1 ? argv[1] : "");
  std::vector<furrow::Affine> palette;
  std::vector<float> morph_weights;
  std::vector<int16_t> weights(1 << 16);
  std::vector<std::byte, furrow::LineAllocator<std::byte>> scratch(1 << 20);

#include "cpp_1_2.inc"

  palette.resize(asset.view().palette.size());
  for (furrow::Affine& matrix : palette) matrix.m[5] = 0.6f;  // squeezed along y
  morph_weights.resize(asset.view().morphs.size());
  if (clusters.scratchBytes() > scratch.size()) return fail("more scratch is needed");

#include "cpp_1_3.inc"

  if (weights[0] < 15000) return fail("the squeezed layer has no weight");

  furrow::FrameInput input;
  input.palette = palette;
  input.morph_weights = morph_weights;
  const uint32_t instance = 42;

  const auto mapped = [&](furrow::Buffer id, uint32_t of) {
    return std::span(made[id]).subspan(of * made[id].size() / 100, made[id].size() / 100);
  };
#include "cpp_2_2.inc"

  if (recorded != 1) return fail("a clustered plan is one dispatch");
  const auto& all = made[furrow::Buffer::kPalette];
  if (std::memcmp(all.data() + instance * plan.instanceBytes(furrow::Buffer::kPalette), palette.data(),
                  sizeof(furrow::Affine)) != 0)
    return fail("the instance's palette is not where it should be");

#include "cpp_3_2.inc"

  std::printf("%s\n", choice.reason);
  if (frame.tier() == furrow::gl::Tier::kCpu && frame.weights()[0] != weights[0])
    return fail("the tiers differ");
  return 0;
}
