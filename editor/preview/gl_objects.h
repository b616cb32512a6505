#pragma once

// Owners of OpenGL objects. All need the context they were made in to be current, destructors too, unless
// that was lost and its objects given up.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <utility>

namespace furrow::preview {

enum class GlKind : uint8_t { kBuffer, kFramebuffer, kProgram, kRenderbuffer, kTexture, kVertexArray };

class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GlKind kind);
  GlObject(GlObject&& other) noexcept { *this = std::move(other); }
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(kind_, other.kind_);
    std::swap(generation_, other.generation_);
    return *this;
  }
  ~GlObject();

  operator uint32_t() const { return name_; }

 private:
  uint32_t name_ = 0;
  GlKind kind_ = GlKind::kBuffer;
  uint32_t generation_ = 0;
};

// The context was lost: objects that were made until now are not deleted by their owners, as their names may
// be another context's by then.
void giveUpObjects();
// Counts these calls.
uint32_t objectGeneration();

// A linked program of GLSL 3.30 without `#version`; each stage is the scene's blocks and then `pieces` in
// order. An empty list: no such stage. Its blocks Scene and Material are bound to 0 and 1. Throws
// pipeline::Error (kEnvironment) with the first line of the log.
using GlslPieces = std::initializer_list<const char*>;
GlObject makeProgram(const char* name, GlslPieces vertex, GlslPieces geometry, GlslPieces fragment);

inline constexpr uint32_t kSceneSlot = 0;
inline constexpr uint32_t kMaterialSlot = 1;

// A buffer with these bytes, for many frames; and other bytes in it, for one.
GlObject makeBuffer(std::span<const std::byte> bytes);
void refill(uint32_t buffer, std::span<const std::byte> bytes);

// A multisampled picture with depth, resolved into a texture.
class PictureTarget {
 public:
  // Throws pipeline::Error: kBadUsage for a size out of range, kEnvironment if there is no memory for it.
  PictureTarget(uint32_t width, uint32_t height);

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  void bind() const;                     // for drawing, viewport too
  uint32_t resolve() const;              // the texture, sRGB
  void readPixels(uint8_t* rgba) const;  // the resolved picture, rows from the bottom

 private:
  uint32_t width_, height_;
  GlObject samples_, depth_, drawn_, texture_, resolved_;
};

}  // namespace furrow::preview
