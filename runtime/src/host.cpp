#include "host.h"

#include <cstdio>

#include "furrow/asset.h"

namespace furrow {
namespace {

static_assert(static_cast<int>(StatusCode::kOk) == FURROW_OK &&
              static_cast<int>(StatusCode::kBadData) == FURROW_BAD_DATA &&
              static_cast<int>(StatusCode::kUnsupportedVersion) == FURROW_UNSUPPORTED_VERSION &&
              static_cast<int>(StatusCode::kUnsupportedFeature) == FURROW_UNSUPPORTED_FEATURE &&
              static_cast<int>(StatusCode::kOutOfMemory) == FURROW_OUT_OF_MEMORY &&
              static_cast<int>(StatusCode::kInvalidArgument) == FURROW_INVALID_ARGUMENT &&
              static_cast<int>(StatusCode::kUnavailable) == FURROW_UNAVAILABLE);
static_assert(sizeof(FurrowStatus::message) == Status::kMessageSize);
static_assert(FURROW_VERSION_MAJOR == FURROW_PROJECT_MAJOR && FURROW_VERSION_MINOR == FURROW_PROJECT_MINOR &&
                  FURROW_VERSION_PATCH == FURROW_PROJECT_PATCH,
              "furrow.h and CMakeLists.txt disagree on the version");

constexpr std::align_val_t alignmentOf(size_t bytes) {
  return std::align_val_t(bytes);
}

Status chooseSimd(uint32_t wanted, Simd& out) {
  out = bestSimd();  // asked for now, it is known when the first frame asks
  if (wanted == FURROW_SIMD_BEST) return {};
  if (wanted > FURROW_SIMD_NEON) return invalid("the context's simd is unknown");
  out = static_cast<Simd>(wanted - FURROW_SIMD_PORTABLE);
  if (!simdAvailable(out))
    return Status::error(StatusCode::kUnavailable, "this CPU or build has no %s", simdName(out));
  return {};
}
static_assert(static_cast<uint32_t>(Simd::kPortable) == 0 &&
              static_cast<uint32_t>(Simd::kNeon) == FURROW_SIMD_NEON - FURROW_SIMD_PORTABLE);

}  // namespace

int32_t report(const Status& status, FurrowStatus* out) {
  if (out) {
    out->code = static_cast<int32_t>(status.code);
    std::memcpy(out->message, status.message, sizeof out->message);
  }
  return static_cast<int32_t>(status.code);
}

Status invalid(const char* what) {
  return Status::error(StatusCode::kInvalidArgument, "%s", what);
}

}  // namespace furrow

void* HostMemory::do_allocate(size_t bytes, size_t alignment) {
  if (!desc_.allocate) return ::operator new(bytes, furrow::alignmentOf(alignment));
  void* memory = desc_.allocate(desc_.user, bytes, alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}

void HostMemory::do_deallocate(void* memory, size_t bytes, size_t alignment) {
  if (desc_.release)
    desc_.release(desc_.user, memory, bytes, alignment);
  else
    ::operator delete(memory, furrow::alignmentOf(alignment));
}

using namespace furrow;

uint32_t furrow_version(void) {
  return FURROW_VERSION_MAJOR << 16 | FURROW_VERSION_MINOR << 8 | FURROW_VERSION_PATCH;
}

uint32_t furrow_format_version(void) {
  return kFormatVersion;
}

int32_t furrow_context_create(const FurrowContextDesc* desc, FurrowContext** context, FurrowStatus* status) {
  if (context) *context = nullptr;
  return guarded(status, [&]() -> Status {
    if (!context) return invalid("context is NULL");
    FurrowContextDesc wanted = {};
    wanted.size = sizeof wanted;
    if (desc)
      if (Status s = readStruct(desc, wanted, "desc"); !s.ok()) return s;
    if (!wanted.allocate != !wanted.release) return invalid("allocate and release must both be given");
    if (wanted.workers == 0 || !wanted.parallel_for) wanted.workers = 1;
    if (wanted.workers > 4096) return invalid("more than 4096 workers");
    Simd simd = Simd::kPortable;
    if (Status s = chooseSimd(wanted.simd, simd); !s.ok()) return s;
    void* memory = HostMemory(wanted).allocate(sizeof(FurrowContext), alignof(FurrowContext));
    *context = new (memory) FurrowContext(wanted);
    (*context)->simd = simd;
    char line[96];
    std::snprintf(line, sizeof line, "furrow %d.%d.%d: cpu tier on %s, %u workers", FURROW_VERSION_MAJOR,
                  FURROW_VERSION_MINOR, FURROW_VERSION_PATCH, simdName(simd), wanted.workers);
    (*context)->log(FURROW_LOG_INFO, line);
    return {};
  });
}

void furrow_context_release(FurrowContext* context) {
  if (!context || !released(context->references)) return;
  const FurrowContextDesc desc = context->desc;
  context->~FurrowContext();
  HostMemory(desc).deallocate(context, sizeof(FurrowContext), alignof(FurrowContext));
}

const char* furrow_context_simd(const FurrowContext* context) {
  return context ? simdName(context->simd) : "";
}
