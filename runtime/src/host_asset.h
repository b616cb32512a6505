#pragma once

#include "furrow/asset.h"
#include "furrow/bind.h"
#include "furrow/pose.h"
#include "host.h"

// The host's memory, counted.
class CountedMemory final : public std::pmr::memory_resource {
 public:
  explicit CountedMemory(std::pmr::memory_resource& host) : host_(host) {}
  size_t bytes() const { return bytes_; }

 private:
  void* do_allocate(size_t bytes, size_t alignment) override {
    void* memory = host_.allocate(bytes, alignment);
    bytes_ += bytes;
    return memory;
  }
  void do_deallocate(void* memory, size_t bytes, size_t alignment) override {
    host_.deallocate(memory, bytes, alignment);
    bytes_ -= bytes;
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource& host_;
  size_t bytes_ = 0;
};

struct FurrowAsset {
  explicit FurrowAsset(FurrowContext& host);
  ~FurrowAsset();
  FurrowAsset(const FurrowAsset&) = delete;
  FurrowAsset& operator=(const FurrowAsset&) = delete;

  FurrowContext& context;
  CountedMemory memory;
  furrow::Asset asset;
  furrow::AssetView view;  // of the asset, with the influences that were kept
  std::pmr::vector<uint16_t> joints, weights;
  furrow::Clusters clusters;  // none where clusters.asset is null
  std::atomic<uint32_t> references = 1;
};

struct FurrowBinding {
  FurrowBinding(FurrowAsset& bound, uint32_t vertices);
  ~FurrowBinding();
  FurrowBinding(const FurrowBinding&) = delete;
  FurrowBinding& operator=(const FurrowBinding&) = delete;

  uint32_t vertexCount() const { return static_cast<uint32_t>(points.size()); }

  FurrowAsset& asset;
  std::pmr::vector<uint32_t> points;   // a vertex of the engine
  std::pmr::vector<uint32_t> element;  // a vertex of the asset: one of the engine, or kAbsent
};

namespace furrow {

Status readStream(const FurrowStream& stream, const char* name, VertexStream& out);

}  // namespace furrow
