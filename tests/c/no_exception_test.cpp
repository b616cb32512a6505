// no_exception_test ASSET.furrow...: C++'s own memory runs out everywhere in turn. Every function of furrow.h
// says so, and neither throws nor leaks.

#include <cstddef>
#include <cstdlib>
#include <functional>
#include <new>

#include "host.h"

namespace {

constexpr long kNever = -1;
long left = kNever;  // allocations until they fail
long made = 0, live = 0;

void* take(size_t bytes, size_t alignment) {
  if (left == 0) throw std::bad_alloc();
  if (left > 0) --left;
  ++made, ++live;
  void* memory = std::aligned_alloc(alignment, (bytes + alignment) / alignment * alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void give(void* memory) {
  live -= memory != nullptr;
  std::free(memory);
}

}  // namespace

void* operator new(size_t bytes) {
  return take(bytes, alignof(std::max_align_t));
}
void* operator new(size_t bytes, std::align_val_t alignment) {
  return take(bytes, static_cast<size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  give(memory);
}
void operator delete(void* memory, size_t) noexcept {
  give(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  give(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  give(memory);
}

namespace {

using namespace furrow::tests;

// `run` gives a code, and has released what it made by then.
void expectEveryFailure(const char* name, const std::function<int32_t()>& run) {
  run();  // what is kept for good is there
  const long before = live, begun = made;
  FURROW_CHECK(run() == FURROW_OK && live == before);
  const long count = made - begun;
  int failed = 0;
  for (long i = 0; i < count; i += 1 + i / 12) {
    left = i;
    const int32_t code = run();
    left = kNever;
    failed += code == FURROW_OUT_OF_MEMORY;
    if (live != before || (code != FURROW_OUT_OF_MEMORY && code != FURROW_OK))
      std::printf("%s: code %d, %ld left over, where allocation %ld of %ld failed\n", name, code,
                  live - before, i, count),
          ++failures;
  }
  FURROW_CHECK(count == 0 || failed > 0);
  std::printf("%s: %ld allocations\n", name, count);
}

void testAsset(const std::vector<char>& file) {
  FurrowContext* context = nullptr;
  FurrowStatus status;
  expectEveryFailure("context", [&] {
    const int32_t code = furrow_context_create(nullptr, &context, &status);
    furrow_context_release(context);
    return code;
  });
  must(furrow_context_create(nullptr, &context, &status), status);
  expectEveryFailure("asset", [&] {
    FurrowAssetDesc desc = {};
    desc.size = sizeof desc, desc.bytes = file.data(), desc.byte_count = file.size(), desc.influences = 2;
    FurrowAsset* asset = nullptr;
    const int32_t code = furrow_asset_create(context, &desc, &asset, &status);
    FURROW_CHECK((asset != nullptr) == (code == FURROW_OK));
    furrow_asset_release(asset);
    return code;
  });
  FurrowAsset* asset = loadAsset(context, file);
  const FurrowAssetInfo info = infoOf(asset);
  expectEveryFailure("instance", [&] {
    FurrowInstanceDesc desc = {};
    desc.size = sizeof desc, desc.features = FURROW_KEEP_NORMALS | FURROW_USE_EASE | FURROW_USE_RECAPTURE;
    FurrowInstance* instance = nullptr;
    const int32_t code = furrow_instance_create(asset, &desc, &instance, &status);
    furrow_instance_release(instance);
    return code;
  });
  const FurrowGeometry geometry = geometryOf(asset);
  for (const float tolerance : {0.0f, 1e-4f})
    expectEveryFailure("binding", [&] {
      FurrowBindDesc desc = {};
      desc.size = sizeof desc, desc.vertices = info.vertices, desc.tolerance = tolerance;
      desc.positions.data = geometry.positions, desc.positions.bytes = 12 * size_t{info.vertices};
      desc.indices = geometry.indices, desc.index_count = 3 * size_t{info.triangles};
      FurrowBinding* binding = nullptr;
      const int32_t code = furrow_binding_create(asset, &desc, &binding, nullptr, &status);
      furrow_binding_release(binding);
      return code;
    });
  for (const uint32_t form : {FURROW_FORM_CLUSTERED, FURROW_FORM_STAGED, FURROW_FORM_RASTER})
    expectEveryFailure("plan", [&] {
      FurrowPlanDesc desc = {};
      desc.size = sizeof desc, desc.form = form, desc.normals = 1, desc.ease = 1;
      FurrowPlan* plan = nullptr;
      const int32_t code = furrow_plan_create(asset, &desc, &plan, &status);
      furrow_plan_release(plan);
      return code;
    });
  furrow_asset_release(asset);
  furrow_context_release(context);
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) testAsset(readFile(argv[i]));
  std::printf("%d failures\n", failures);
  return failures || argc < 2 ? 1 : 0;
}
