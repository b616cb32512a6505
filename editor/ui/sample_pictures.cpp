#include "editor/ui/sample_pictures.h"

#include <epoxy/gl.h>

#include <span>

#include "pipeline/maps/image.h"
#include "sample_pictures_bytes.h"

namespace furrow::editor::ui {

ImTextureID SamplePictures::texture(int index) {
  if (generation_ != preview::objectGeneration())
    for (preview::GlObject& texture : textures_) texture = {};
  generation_ = preview::objectGeneration();
  preview::GlObject& texture = textures_[index];
  if (texture == 0) {
    const std::span<const uint8_t> bytes =
        index == 0 ? std::span<const uint8_t>(pictures::kFace) : std::span<const uint8_t>(pictures::kJacket);
    const pipeline::ByteImage image = pipeline::readByteImage(bytes, "sample");
    texture = preview::GlObject(preview::GlKind::kTexture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, static_cast<int>(image.width), static_cast<int>(image.height), 0,
                 image.channels == 4 ? GL_RGBA : GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
    glGenerateMipmap(GL_TEXTURE_2D);
  }
  return reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(static_cast<uint32_t>(texture)));
}

}  // namespace furrow::editor::ui
