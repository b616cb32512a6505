// threads_test ASSET.furrow SLEEVE.furrow: many instances of one asset on many threads, with one binding too,
// assets loading and instances going over to them meanwhile; and the same bits, of pictures too, for any
// number of threads, on every instruction set, on both sides of every seam.

#include <algorithm>
#include <atomic>
#include <latch>
#include <thread>

#include "host.h"

namespace {

using namespace furrow::tests;

// A job system: as many threads as there are workers, ranges handed out one by one.
void onThreads(void* user, uint32_t count, uint32_t grain, FurrowTask task, void* data) {
  const auto workers = *static_cast<const uint32_t*>(user);
  std::atomic<uint32_t> next = 0;
  std::vector<std::jthread> pool;
  for (uint32_t worker = 0; worker < workers; ++worker)
    pool.emplace_back([&, worker] {
      for (uint32_t begin; (begin = next.fetch_add(grain)) < count;)
        task(data, begin, std::min(begin + grain, count), worker);
    });
}

FurrowContext* makeContext(uint32_t* workers, uint32_t simd = FURROW_SIMD_BEST) {
  FurrowContextDesc desc = {};
  desc.size = sizeof desc;
  desc.simd = simd;
  if (workers) desc.user = workers, desc.workers = *workers, desc.parallel_for = onThreads;
  FurrowContext* context = nullptr;
  FurrowStatus status;
  if (furrow_context_create(&desc, &context, &status) == FURROW_UNAVAILABLE) return nullptr;
  must(status.code, status);
  return context;
}

std::vector<int16_t> weightsOf(const FurrowInstance* instance, const FurrowAssetInfo& info) {
  const int16_t* w = furrow_instance_weights(instance);
  return {w, w + size_t{info.vertices} * info.weight_stride};
}

void run(FurrowInstance* instance, const FurrowFrame& frame) {
  FurrowStatus status;
  must(furrow_instance_frame(instance, &frame, nullptr, &status), status);
}

// As floats.
std::vector<float> pictureOf(const FurrowAsset* asset, const FurrowAssetInfo& info,
                             const FurrowInstance* instance) {
  constexpr uint32_t kWidth = 200, kHeight = 150;
  const std::vector<float> colors(3 * size_t{info.vertices}, 0.5f);
  std::vector<float> pixels(size_t{4} * kWidth * kHeight);
  FurrowPicture picture = {};
  picture.size = sizeof picture;
  picture.positions = furrow_instance_positions(instance);
  picture.width = kWidth, picture.height = kHeight;
  picture.colors = colors.data();
  picture.weights = furrow_instance_weights(instance);
  for (const int i : {0, 5, 10, 15}) picture.view_projection[i] = i == 15 ? 1.0f : 2.0f;
  picture.memory_bytes = furrow_picture_memory(asset, kWidth, kHeight);
  void* memory = std::aligned_alloc(64, (picture.memory_bytes + 63) / 64 * 64);
  picture.memory = memory;
  picture.picture = pixels.data();
  FurrowStatus status;
  must(furrow_picture_draw(asset, &picture, &status), status);
  std::free(memory);
  return pixels;
}

void testSameBits(const std::vector<char>& file) {
  std::vector<std::vector<int16_t>> expected;
  std::vector<float> expected_picture;
  for (uint32_t workers : {1u, 2u, 5u})
    for (uint32_t simd = FURROW_SIMD_PORTABLE; simd <= FURROW_SIMD_NEON; ++simd) {
      FurrowContext* context = makeContext(&workers, simd);
      if (!context) continue;
      FurrowAsset* asset = loadAsset(context, file);
      const FurrowAssetInfo info = infoOf(asset);
      const std::vector<float> palette = squeezed(info, 0.7f);
      const std::vector<float> morphs(info.morphs, 0.3f);
      FurrowFrame frame = paletteFrame(palette);
      frame.morph_weights = morphs.data(), frame.morph_count = info.morphs;
      std::vector<std::vector<int16_t>> weights;
      std::vector<float> picture;
      const std::vector<float> rest = squeezed(info, 0.9f);
      const std::vector<FurrowEase> eases(FURROW_MAX_LAYERS, {3.0f, 1.0f});
      for (uint32_t features :
           {0u, uint32_t{FURROW_KEEP_NORMALS}, uint32_t{FURROW_USE_LAPLACE},
            uint32_t{FURROW_USE_DUAL_QUATERNIONS}, uint32_t{FURROW_USE_RECAPTURE | FURROW_USE_EASE}}) {
        FurrowInstance* instance = makeInstance(asset, features);
        if (features & FURROW_USE_RECAPTURE) {
          const FurrowFrame pose = paletteFrame(rest);
          FurrowStatus status;
          must(furrow_instance_recapture(instance, &pose, &status), status);
        }
        frame.laplace_steps = features & FURROW_USE_LAPLACE ? 2 : 0;
        frame.skinning =
            features & FURROW_USE_DUAL_QUATERNIONS ? FURROW_SKINNING_DUAL_QUATERNION : FURROW_SKINNING_LINEAR;
        frame.eases = features & FURROW_USE_EASE ? eases.data() : nullptr;
        run(instance, frame);
        weights.push_back(weightsOf(instance, info));
        if (features & FURROW_KEEP_NORMALS) picture = pictureOf(asset, info, instance);
        furrow_instance_release(instance);
      }
      if (expected_picture.empty()) expected_picture = picture;
      FURROW_CHECK(picture == expected_picture);
      if (expected.empty()) expected = weights;
      FURROW_CHECK(weights == expected);

      // Vertices of one point: the same bits, but for what was painted on each.
      const FurrowGeometry geometry = geometryOf(asset);
      uint32_t seams = 0;
      for (uint32_t l = 0; l < info.layers; ++l) {
        FurrowLayerInfo layer = {};
        layer.size = sizeof layer;
        furrow_layer_info(asset, l, &layer, nullptr);
        for (uint32_t v = 0; v < info.vertices && !layer.has_bias; ++v) {
          const uint32_t other = geometry.point_vertex[geometry.vertex_point[v]];
          seams += other != v;
          for (const auto& each : weights)
            FURROW_CHECK(each[size_t{v} * info.weight_stride + l] ==
                         each[size_t{other} * info.weight_stride + l]);
        }
      }
      FURROW_CHECK(seams > 0);
      size_t drawn = 0;
      for (size_t i = 3; i < picture.size(); i += 4) drawn += picture[i] > 0.0f;
      FURROW_CHECK(drawn > 500);
      furrow_asset_release(asset);
      furrow_context_release(context);
    }
}

// The newest asset, as a game would pass it from the thread that loads to those that animate.
class Slot {
 public:
  explicit Slot(FurrowAsset* asset) : asset_(asset) {}
  ~Slot() { furrow_asset_release(asset_); }
  void put(FurrowAsset* asset) {
    const Guard guard(*this);
    std::swap(asset_, asset);
    furrow_asset_release(asset);
  }
  FurrowAsset* get() {
    const Guard guard(*this);
    furrow_asset_retain(asset_);
    return asset_;
  }

 private:
  struct Guard {
    explicit Guard(Slot& s) : slot(s) {
      while (slot.busy_.test_and_set(std::memory_order_acquire)) std::this_thread::yield();
    }
    ~Guard() { slot.busy_.clear(std::memory_order_release); }
    Slot& slot;
  };
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
  FurrowAsset* asset_;
};

void testReloadUnderRunningInstances(const std::vector<char>& a, const std::vector<char>& b) {
  constexpr int kThreads = 4, kInstances = 3, kLoads = 4;
  FurrowContext* context = makeContext(nullptr);
  Slot slot(loadAsset(context, a));
  std::vector<std::vector<int16_t>> expected;  // of each file
  for (const auto* file : {&a, &b}) {
    FurrowAsset* asset = loadAsset(context, *file);
    FurrowInstance* instance = makeInstance(asset, 0);
    const std::vector<float> palette = squeezed(infoOf(asset), 0.75f);
    run(instance, paletteFrame(palette));
    expected.push_back(weightsOf(instance, infoOf(asset)));
    furrow_instance_release(instance);
    furrow_asset_release(asset);
  }
  std::atomic<int> reloads = 0;
  std::atomic<bool> all_loaded = false;
  std::latch all_run(kThreads);  // however late they start, the assets are loaded under them
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t)
      threads.emplace_back([&] {
        std::vector<FurrowInstance*> instances;
        FurrowAsset* asset = slot.get();
        for (int i = 0; i < kInstances; ++i)
          instances.push_back(makeInstance(asset, i == 1 ? FURROW_USE_EASE : 0));
        all_run.count_down();
        for (bool last = false; !last;) {
          last = all_loaded;
          FurrowAsset* newest = slot.get();
          for (FurrowInstance*& instance : instances) {
            if (furrow_instance_asset(instance) != newest) {
              FurrowStatus status;
              must(furrow_instance_reload(&instance, newest, nullptr, 0, &status), status);
              ++reloads;
            }
            const FurrowAssetInfo info = infoOf(furrow_instance_asset(instance));
            const std::vector<float> palette = squeezed(info, 0.75f);
            run(instance, paletteFrame(palette));
            const std::vector<int16_t> weights = weightsOf(instance, info);
            FURROW_CHECK(weights == expected[0] || weights == expected[1]);
          }
          furrow_asset_release(newest);
        }
        for (FurrowInstance* instance : instances) furrow_instance_release(instance);
        furrow_asset_release(asset);
      });
    threads.emplace_back([&] {
      all_run.wait();
      for (int i = 0; i < kLoads; ++i) slot.put(loadAsset(context, i % 2 ? a : b));
      all_loaded = true;
    });
  }
  FURROW_CHECK(reloads >= kThreads * kInstances);
  furrow_context_release(context);  // the slot's asset holds it until the end of the scope
}

// A mesh of the engine's that all its instances share, the asset's own vertices backwards.
void testOneBindingForAllInstances(const std::vector<char>& file) {
  FurrowContext* context = makeContext(nullptr);
  FurrowAsset* asset = loadAsset(context, file);
  const FurrowAssetInfo info = infoOf(asset);
  FurrowStatus status;
  const FurrowGeometry geometry = geometryOf(asset);
  const FurrowPartInfo part = partOf(asset, 0);
  std::vector<float> vertices(3 * size_t{part.vertex_end});
  for (size_t v = part.vertex_begin; v < part.vertex_end; ++v)
    std::copy_n(geometry.positions + 3 * v, 3, &vertices[3 * (part.vertex_end - 1 - v)]);
  FurrowBindDesc desc = {};
  desc.size = sizeof desc;
  desc.positions = {vertices.data(), vertices.size() * sizeof(float), 0, 0, FURROW_FLOAT3};
  desc.vertices = part.vertex_end - part.vertex_begin;
  std::copy_n(part.rest, 12, desc.to_root);
  desc.tolerance = 2.0f * info.position_error;
  FurrowBinding* binding = nullptr;
  FurrowBindCounts counts = {};
  counts.size = sizeof counts;
  must(furrow_binding_create(asset, &desc, &binding, &counts, &status), status);
  FURROW_CHECK(counts.matched > desc.vertices / 2);

  for (size_t v = 0; v < vertices.size(); v += 3) vertices[v] *= 0.7f;
  constexpr size_t kThreads = 4;
  std::vector<float> weights[kThreads];
  {
    std::vector<std::jthread> threads;
    for (auto& out : weights)
      threads.emplace_back([&] {
        FurrowInstance* instance = makeInstance(asset, FURROW_KEEP_POSITIONS);
        const FurrowPosedMesh mesh = {desc.positions, {}, binding};
        FurrowFrame frame = {};
        frame.size = sizeof frame, frame.meshes = &mesh, frame.mesh_count = 1;
        run(instance, frame);
        FurrowReadDesc read = {};
        read.size = sizeof read, read.binding = binding, read.format = FURROW_WEIGHTS_FLOAT;
        out.resize(size_t{desc.vertices} * info.layers);
        read.out = out.data(), read.bytes = out.size() * sizeof(float);
        FurrowStatus own;
        must(furrow_instance_read(instance, &read, &own), own);
        furrow_instance_release(instance);
      });
  }
  for (const auto& each : weights) FURROW_CHECK(each == weights[0]);
  FURROW_CHECK(std::any_of(weights[0].begin(), weights[0].end(), [](float w) { return w > 0.1f; }));
  furrow_binding_release(binding);
  furrow_asset_release(asset);
  furrow_context_release(context);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::vector<char> other = readFile(argv[1]), sleeve = readFile(argv[2]);
  testSameBits(sleeve);
  testReloadUnderRunningInstances(other, sleeve);
  testOneBindingForAllInstances(sleeve);
  std::printf("%d failures\n", failures);
  return failures ? 1 : 0;
}
