#pragma once

// What furrow.h's objects share: the host's hooks, counted references and the ways across the C boundary.

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory_resource>
#include <new>
#include <utility>

#include "furrow/cluster_frame.h"
#include "furrow/furrow.h"
#include "furrow/status.h"

// The host's allocator as a C++ memory resource.
class HostMemory final : public std::pmr::memory_resource {
 public:
  explicit HostMemory(const FurrowContextDesc& desc) : desc_(desc) {}

 private:
  void* do_allocate(size_t bytes, size_t alignment) override;
  void do_deallocate(void* memory, size_t bytes, size_t alignment) override;
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  const FurrowContextDesc& desc_;
};

struct FurrowContext {
  explicit FurrowContext(const FurrowContextDesc& d) : desc(d), memory(desc) {}
  FurrowContext(const FurrowContext&) = delete;
  FurrowContext& operator=(const FurrowContext&) = delete;

  void log(int32_t severity, const char* message) const {
    if (desc.log) desc.log(desc.user, severity, message);
  }

  FurrowContextDesc desc;
  HostMemory memory;
  furrow::Simd simd = furrow::Simd::kPortable;
  std::atomic<uint32_t> references = 1;
};

namespace furrow {

inline void retain(std::atomic<uint32_t>& references) {
  references.fetch_add(1, std::memory_order_relaxed);
}

// True for the last one, which then sees all that the others did.
inline bool released(std::atomic<uint32_t>& references) {
  return references.fetch_sub(1, std::memory_order_acq_rel) == 1;
}

int32_t report(const Status& status, FurrowStatus* out);
Status invalid(const char* what);

// Runs a function's body, which returns a Status; nothing is thrown across the C boundary.
template <typename Body>
int32_t guarded(FurrowStatus* out, Body body) noexcept {
  try {
    return report(body(), out);
  } catch (const std::bad_alloc&) {
    return report(Status::error(StatusCode::kOutOfMemory, "out of memory"), out);
  } catch (...) {
    return report(Status::error(StatusCode::kInvalidArgument, "unexpected failure"), out);
  }
}

// The host's struct as this library knows it: what the host's header lacked is zero, what only a newer one
// has must be.
template <typename T>
Status readStruct(const T* in, T& out, const char* name) {
  constexpr size_t kMost = 4096;
  if (!in) return Status::error(StatusCode::kInvalidArgument, "%s is NULL", name);
  if (in->size < sizeof(size_t) || in->size > kMost)
    return Status::error(StatusCode::kInvalidArgument, "%s.size is not the struct's size", name);
  const auto* bytes = reinterpret_cast<const unsigned char*>(in);
  for (size_t i = sizeof(T); i < in->size; ++i)
    if (bytes[i] != 0)
      return Status::error(StatusCode::kUnsupportedFeature, "%s has a field that this library does not know",
                           name);
  out = {};
  std::memcpy(&out, in, std::min(in->size, sizeof(T)));
  return {};
}

// As much of `value` as the host's struct has room for; its size stays.
template <typename T>
Status writeStruct(T value, T* out) {
  constexpr size_t kMost = 4096;
  if (!out || out->size < sizeof(size_t) || out->size > kMost)
    return invalid(out ? "the size of the struct to fill is not set" : "the struct to fill is NULL");
  value.size = out->size;
  std::memcpy(out, &value, std::min(out->size, sizeof(T)));
  return {};
}

// f(begin, end, worker) over [0, count) by the host's job system. False if the host numbered its workers
// wrongly.
template <typename Function>
bool parallel(const FurrowContext& context, uint32_t count, uint32_t grain, const Function& f) {
  const FurrowContextDesc& host = context.desc;
  if (!host.parallel_for || host.workers == 1 || count <= grain) {
    f(0u, count, 0u);
    return true;
  }
  struct Call {
    const Function& f;
    uint32_t workers, count;
    std::atomic<bool> sound = true;
  } call{f, host.workers, count};
  host.parallel_for(
      host.user, count, grain,
      [](void* data, uint32_t begin, uint32_t end, uint32_t worker) {
        Call& c = *static_cast<Call*>(data);
        if (worker < c.workers && begin <= end && end <= c.count)
          c.f(begin, end, worker);
        else
          c.sound.store(false, std::memory_order_relaxed);
      },
      &call);
  return call.sound.load(std::memory_order_relaxed);
}

// What parallel() came to.
inline Status soundness(bool sound) {
  return sound ? Status()
               : invalid("parallel_for went beyond its count or its workers; the frame is not whole");
}

// An object of the host's memory.
template <typename T, typename... Arguments>
T* create(FurrowContext& context, Arguments&&... arguments) {
  void* memory = context.memory.allocate(sizeof(T), alignof(T));
  try {
    return new (memory) T(std::forward<Arguments>(arguments)...);
  } catch (...) {
    context.memory.deallocate(memory, sizeof(T), alignof(T));
    throw;
  }
}

template <typename T>
void destroy(FurrowContext& context, T* object) {
  object->~T();
  context.memory.deallocate(object, sizeof(T), alignof(T));
}

}  // namespace furrow
