// quiet_frame_test FACE.furrow SLEEVE.furrow: frames of every kind in a process that the kernel kills at the
// first system call, with every allocation and lock of the process counted. From the first frame on there are
// none.

#include <linux/seccomp.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <mutex>

#include "furrow/raster.h"
#include "host.h"

namespace {

// Counted while a frame runs; plain numbers, for the child has one thread.
bool counting = false;
int allocations = 0, locks = 0;

}  // namespace

extern "C" {

void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void __libc_free(void*);

// NOLINTBEGIN: these take the place of the C library's own.
void* malloc(size_t bytes) {
  allocations += counting;
  return __libc_malloc(bytes);
}
void* calloc(size_t count, size_t bytes) {
  allocations += counting;
  return __libc_calloc(count, bytes);
}
void* realloc(void* memory, size_t bytes) {
  allocations += counting;
  return __libc_realloc(memory, bytes);
}
void* memalign(size_t alignment, size_t bytes) {
  allocations += counting;
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  return memalign(alignment, bytes);
}
int posix_memalign(void** out, size_t alignment, size_t bytes) {
  *out = memalign(alignment, bytes);
  return *out ? 0 : 12;
}
void free(void* memory) {
  allocations += counting && memory;
  __libc_free(memory);
}

// While frames are counted there is one thread: taking a lock comes to nothing but the count.
int pthread_mutex_lock(pthread_mutex_t*) {
  locks += counting;
  return 0;
}
int pthread_mutex_trylock(pthread_mutex_t*) {
  locks += counting;
  return 0;
}
int pthread_mutex_unlock(pthread_mutex_t*) {
  return 0;
}
int pthread_rwlock_rdlock(pthread_rwlock_t*) {
  locks += counting;
  return 0;
}
int pthread_rwlock_wrlock(pthread_rwlock_t*) {
  locks += counting;
  return 0;
}
int pthread_rwlock_unlock(pthread_rwlock_t*) {
  return 0;
}
// What the first use of a function's static locks.
int __cxa_guard_acquire(char* done) {
  locks += counting;
  return *done == 0;
}
void __cxa_guard_release(char* done) {
  *done = 1;
}
int pthread_spin_lock(pthread_spinlock_t*) {
  locks += counting;
  return 0;
}
int sem_wait(sem_t*) {
  locks += counting;
  return 0;
}
// NOLINTEND
}

namespace {

using namespace furrow::tests;

void inRanges(void*, uint32_t count, uint32_t grain, FurrowTask task, void* data) {
  uint32_t worker = 0;
  for (uint32_t begin = 0; begin < count; begin += grain, worker = 1 - worker)
    task(data, begin, std::min(begin + grain, count), worker);
}

// Runs `frames` in a child. 0: quiet; else what it did.
enum Noise { kQuiet = 0, kSystemCall = 1, kAllocation = 2, kLock = 3, kFailure = 4 };
Noise noiseOf(const std::function<bool()>& frames) {
  const pid_t child = fork();
  if (child == 0) {
    counting = true;
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) syscall(SYS_exit, 77);
    const bool good = frames();
    counting = false;
    syscall(SYS_exit, allocations ? kAllocation : locks ? kLock : good ? kQuiet : kFailure);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) return kSystemCall;
  if (WEXITSTATUS(status) == 77) std::printf("no seccomp on this machine\n"), std::exit(77);
  return static_cast<Noise>(WEXITSTATUS(status));
}

void quiet(const char* what, const std::function<bool()>& frames) {
  constexpr const char* kNames[] = {"", "made a system call", "allocated", "took a lock", "failed"};
  const Noise noise = noiseOf(frames);
  if (noise == kQuiet) return;
  std::printf("%s %s\n", what, kNames[noise]);
  ++failures;
}

void* volatile sink;
std::mutex* mutex_of_ours = new std::mutex;

// The counters count and the kernel kills, or the test says nothing.
void testTheTest() {
  FURROW_CHECK(noiseOf([] { return true; }) == kQuiet);
  FURROW_CHECK(noiseOf([] { return false; }) == kFailure);
  FURROW_CHECK(noiseOf([] { return getppid() != 0; }) == kSystemCall);
  FURROW_CHECK(noiseOf([] {
                 sink = ::operator new(40);
                 return true;
               }) == kAllocation);
  FURROW_CHECK(noiseOf([] {
                 const std::lock_guard lock(*mutex_of_ours);
                 return true;
               }) == kLock);
}

struct Subject {
  FurrowAsset* asset;
  FurrowAssetInfo info;
  std::vector<float> palette, morph_weights;
  std::vector<float> rest, occlusion, delta;
  std::vector<const float*> deltas;
  std::vector<unsigned char> halves;
  FurrowBinding* binding = nullptr;

  Subject(FurrowContext* context, const std::vector<char>& file, uint32_t flags)
      : asset(loadAsset(context, file, flags)),
        info(infoOf(asset)),
        palette(squeezed(info, 0.8f)),
        morph_weights(info.morphs, 0.25f),
        rest(info.vertices, 1.0f),
        occlusion(info.vertices),
        delta(info.vertices, -0.1f),
        deltas(info.morphs, delta.data()),
        halves(6 * size_t{info.vertices}) {
    FurrowStatus status;
    const FurrowGeometry geometry = geometryOf(asset);
    const FurrowPartInfo part = partOf(asset, 0);
    FurrowBindDesc desc = {};
    desc.size = sizeof desc;
    desc.positions.data = geometry.positions, desc.positions.bytes = 12 * size_t{info.vertices};
    desc.vertices = info.vertices;
    desc.indices = geometry.indices, desc.index_count = 3 * size_t{info.triangles};
    std::copy_n(part.rest, 12, desc.to_root);
    desc.tolerance = 1e-4f;
    must(furrow_binding_create(asset, &desc, &binding, nullptr, &status), status);
  }
  ~Subject() {
    furrow_binding_release(binding);
    furrow_asset_release(asset);
  }

  FurrowFrame frame() const {
    FurrowFrame out = paletteFrame(palette);
    out.morph_weights = morph_weights.data(), out.morph_count = info.morphs;
    return out;
  }
};

void testFrames(Subject& s) {
  constexpr uint32_t kEverything = FURROW_KEEP_NORMALS | FURROW_USE_DUAL_QUATERNIONS | FURROW_USE_LAPLACE |
                                   FURROW_USE_RECAPTURE | FURROW_USE_EASE;
  FurrowInstance* bare = makeInstance(s.asset, 0);
  FurrowInstance* full = makeInstance(s.asset, kEverything);
  FurrowFrameReport report = {};
  report.size = sizeof report;
  const auto ok = [&](FurrowInstance* instance, const FurrowFrame& frame) {
    FurrowStatus status;
    return furrow_instance_frame(instance, &frame, &report, &status) == FURROW_OK && report.computed;
  };

  FurrowFrame plain = s.frame();
  quiet("a frame", [&] { return ok(bare, plain) && ok(bare, plain); });
  quiet("a frame with normals", [&] { return ok(full, plain); });
  FurrowFrame dual = plain;
  dual.skinning = FURROW_SKINNING_DUAL_QUATERNION;
  quiet("dual quaternions", [&] { return ok(full, dual); });

  FurrowPosedMesh mesh = {};
  FurrowFrame meshes = {};
  meshes.size = sizeof meshes;
  meshes.meshes = &mesh, meshes.mesh_count = 1;
  std::vector<float> positions(3 * size_t{s.info.vertices}, 0.5f);
  mesh.from.data = positions.data(), mesh.from.bytes = 4 * positions.size();
  quiet("posed vertices", [&] { return ok(bare, meshes); });
  mesh.from.data = s.halves.data(), mesh.from.bytes = s.halves.size(), mesh.from.format = FURROW_HALF3;
  mesh.to = mesh.from, mesh.binding = s.binding;
  meshes.key_time = 0.3f;
  quiet("key frames of halves, bound", [&] { return ok(full, meshes); });

  const std::vector<FurrowEase> eases(FURROW_MAX_LAYERS, {3.0f, 1.0f});
  FurrowFrame all = plain;
  all.laplace_steps = 3, all.eases = eases.data(), all.seconds = 0.016f, all.fade_out = 0.25f;
  all.occlusion = s.occlusion.data(), all.occlusion_rest = s.rest.data(),
  all.occlusion_deltas = s.deltas.data();
  quiet("every stage", [&] { return ok(full, all) && ok(full, all); });
  quiet("recapture", [&] {
    return furrow_instance_recapture(full, &plain, nullptr) == FURROW_OK && ok(full, plain) &&
           report.clustered == s.info.clustered && ok(full, all) &&
           furrow_instance_forget_rest(full, nullptr) == FURROW_OK;
  });
  FurrowFrame skipped = plain;
  skipped.every = 1000;
  quiet("a frame that is not due", [&] {
    FurrowStatus status;
    return ok(bare, skipped) && furrow_instance_frame(bare, &skipped, &report, &status) == FURROW_OK &&
           !report.computed;
  });
  FurrowFrame wrong = plain;
  wrong.palette_count = 0;
  quiet("a frame that is refused", [&] {
    FurrowStatus status;
    return furrow_instance_frame(bare, &wrong, &report, &status) == FURROW_INVALID_ARGUMENT;
  });

  std::vector<float> out(size_t{s.info.vertices} * s.info.layers);
  FurrowReadDesc read = {};
  read.size = sizeof read;
  read.binding = s.binding, read.format = FURROW_WEIGHTS_FLOAT, read.out = out.data(),
  read.bytes = 4 * out.size();
  quiet("reading weights", [&] { return furrow_instance_read(bare, &read, nullptr) == FURROW_OK; });

  FurrowPlanDesc desc = {};
  desc.size = sizeof desc, desc.skinning = FURROW_SKINNING_DUAL_QUATERNION;
  FurrowPlan* plan = nullptr;
  FurrowStatus status;
  must(furrow_plan_create(s.asset, &desc, &plan, &status), status);
  std::vector<float> bytes(4096 + 17 * s.palette.size() + 2 * s.morph_weights.size());
  quiet("what a plan takes", [&] {
    for (uint32_t role : {FURROW_BUFFER_FRAME, FURROW_BUFFER_PALETTE, FURROW_BUFFER_MORPH_WEIGHTS})
      if ((role != FURROW_BUFFER_MORPH_WEIGHTS || s.info.morphs > 0) &&
          furrow_plan_write(plan, role, &plain, bytes.data(), 4 * bytes.size(), nullptr) != FURROW_OK)
        return false;
    return true;
  });
  furrow_plan_release(plan);
  furrow_instance_release(bare);
  furrow_instance_release(full);
}

void testRaster(const std::vector<char>& file) {
  using namespace furrow;
  Asset asset;
  if (!asset.load(std::as_bytes(std::span(file))).ok()) std::exit(2);
  const AssetView& view = asset.view();
  const std::vector<Float3> colors(view.vertexCount(), {0.5f, 0.5f, 0.5f});
  std::vector<RasterVertex> vertices(view.vertexCount());
  std::vector<Float4> picture(64 * 64);
  alignas(64) static std::byte scratch[kRasterScratchBytes];
  RasterJob job;
  job.asset = &view;
  job.positions = view.positions;
  job.width = job.height = 64;
  job.colors = colors;
  job.vertices = vertices;
  job.picture = picture;
  std::vector<uint64_t> bins(rasterBinWords(view.triangleCount(), 64, 64));
  job.bins = bins;
  const Status status = job.validate();
  if (!status.ok()) std::printf("%s\n", status.message), std::exit(2);
  quiet("a picture", [&] {
    job.project(0, view.vertexCount());
    job.bin(0, rasterBatches(view.triangleCount()));
    job.draw(0, rasterTiles(64, 64), scratch);
    return true;
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  testTheTest();
  FurrowStatus status;
  FurrowContext* context = nullptr;
  FurrowContextDesc desc = {};
  desc.size = sizeof desc;
  desc.parallel_for = inRanges, desc.workers = 2;
  must(furrow_context_create(&desc, &context, &status), status);
  for (int i = 1; i < 3; ++i)
    for (uint32_t flags : {uint32_t{0}, uint32_t{FURROW_ASSET_STAGED}}) {
      Subject subject(context, readFile(argv[i]), flags);
      testFrames(subject);
    }
  furrow_context_release(context);
  testRaster(readFile(argv[2]));
  std::printf("%d failures\n", failures);
  return failures ? 1 : 0;
}
