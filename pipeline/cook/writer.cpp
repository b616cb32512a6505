#include "pipeline/cook/writer.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>
#include <map>

#include "asset_header.h"
#include "pipeline/pack/morphs.h"
#include "pipeline/pack/rig_section.h"
#include "pipeline/parallel.h"

namespace furrow::pipeline {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

template <typename T>
Offset<flatbuffers::Vector<uint8_t>> bytesVector(FlatBufferBuilder& builder, const std::vector<T>& bytes) {
  static_assert(sizeof(T) == 1);
  return builder.CreateVector(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

template <typename T>
std::vector<T> padded(std::vector<T> values) {  // streams hold whole words
  values.resize((values.size() * sizeof(T) + 3) / 4 * 4 / sizeof(T), T(0));
  return values;
}

template <typename T>
PackedStream packed(const std::vector<T>& values, uint32_t stride) {
  return packStream(values.data(), stride, values.size() * sizeof(T) / stride);
}

class Writer {
 public:
  Writer(const PackInput& input, uint32_t threads) : in_(input) { packLargest(threads); }

  std::vector<std::byte> write() {
    std::vector<Offset<format::Part>> parts;
    for (const PackedPart& part : in_.parts) parts.push_back(writePart(b_, part));
    std::vector<Offset<format::PaletteEntry>> palette;
    for (const PaletteEntry& entry : in_.scene.rig.palette)
      palette.push_back(
          format::CreatePaletteEntry(b_, b_.CreateSharedString(in_.scene.rig.nodes[entry.node].name),
                                     entry.node, b_.CreateVector(affineRows(entry.inverse_bind))));
    std::vector<Offset<format::Morph>> morphs = writeMorphs();
    std::vector<Offset<format::Layer>> layers;
    for (size_t l = 0; l < in_.layers.size(); ++l) layers.push_back(writeLayer(l));
    std::vector<Offset<format::TextureSet>> sets;
    for (const BakedTextureSet& set : in_.texture_sets)
      sets.push_back(format::CreateTextureSet(
          b_, b_.CreateString(set.name), writeTexture(set.normals), writeTexture(set.shading),
          writeTexture(set.masks), b_.CreateVector(set.compress_slice), b_.CreateVector(set.stretch_slice),
          set.windows.empty() ? 0 : b_.CreateVector(&set.windows[0].x, 4 * set.windows.size())));
    const auto vertex_point = writeStream(b_, packed(in_.surface.vertex_point, 4));
    const auto rest = std::holds_alternative<RestBind>(in_.recipe.rest)
                          ? Offset<format::Stream>()
                          : streamOf(in_.surface.point_positions, sizeof(glm::vec3));
    const auto place_points = writeStream(b_, packed(in_.place_points, 8));
    const auto colors = streamOf(in_.colors, sizeof(glm::u8vec4));
    const auto base_maps = writeBaseMaps();
    const auto asset = format::CreateAsset(
        b_, b_.CreateString(FURROW_VERSION), b_.CreateString(in_.scene.file.filename().string()),
        in_.influences, static_cast<float>(in_.position_error), b_.CreateVector(parts),
        b_.CreateVector(palette), b_.CreateVector(morphs), b_.CreateVector(layers), b_.CreateVector(sets),
        static_cast<uint32_t>(in_.surface.point_positions.size()), vertex_point, rest,
        bytesVector(b_, in_.weld.hash), place_points, bytesVector(b_, writeRig(in_.scene.rig)),
        static_cast<float>(morph_error_), colors, base_maps, in_.place_error);
    format::FinishAssetBuffer(b_, asset);

    AssetHeader header = {};
    std::memcpy(header.magic, kAssetMagic, sizeof header.magic);
    header.version = kFormatVersion;
    header.payload_bytes = b_.GetSize();
    header.payload_hash = XXH3_64bits_withSeed(b_.GetBufferPointer(), b_.GetSize(), kFormatVersion);
    std::vector<std::byte> file(sizeof header + b_.GetSize());
    std::memcpy(file.data(), &header, sizeof header);
    std::memcpy(file.data() + sizeof header, b_.GetBufferPointer(), b_.GetSize());
    return file;
  }

 private:
  struct Morph {
    float position_step, normal_step;
    PackedStream runs, positions, normals;
  };

  // The textures, and beside them the morph targets one after the other.
  void packLargest(uint32_t threads) {
    std::vector<const EncodedTexture*> textures;
    for (const BakedTextureSet& set : in_.texture_sets)
      textures.insert(textures.end(), {&set.normals, &set.shading, &set.masks});
    for (const BakedBaseMaps& maps : in_.base_maps)
      textures.insert(textures.end(), {&maps.color, &maps.normal});
    for (const EncodedTexture* texture : textures) textures_[texture];
    parallelFor(static_cast<uint32_t>(textures.size()) + 1, threads, [&](uint32_t i) {
      if (i == 0) return packMorphs();
      const EncodedTexture& texture = *textures[i - 1];
      textures_.at(&texture) =
          packed(texture.data, static_cast<uint32_t>(textureLevelBytes(texture.format, 1, 1, 0)));
    });
  }

  void packMorphs() {
    if (in_.scene.rig.morphs.empty()) return;
    MorphPacker packer(in_.scene, in_.surface, in_.source_vertex);
    for (uint32_t m = 0; m < in_.scene.rig.morphs.size(); ++m) {
      const PackedMorph morph = packer.pack(m);
      morph_error_ = std::max(morph_error_, morph.error);
      morphs_.push_back({morph.position_step, morph.normal_step, packed(morph.runs, 8),
                         packed(morph.positions, morph.position_stride), packed(morph.normals, 4)});
    }
  }

  std::vector<Offset<format::Morph>> writeMorphs() {
    std::vector<Offset<format::Morph>> out;
    for (size_t m = 0; m < morphs_.size(); ++m) {
      const Morph morph = std::move(morphs_[m]);
      const MorphTarget& target = in_.scene.rig.morphs[m];
      const auto runs = unlessEmpty(morph.runs), positions = unlessEmpty(morph.positions),
                 normals = unlessEmpty(morph.normals);
      out.push_back(format::CreateMorph(b_, b_.CreateString(target.name),
                                        static_cast<float>(target.default_weight), morph.position_step,
                                        morph.normal_step, runs, positions, normals));
    }
    return out;
  }

  Offset<format::Layer> writeLayer(size_t index) {
    const LayerRecipe& recipe = in_.recipe.layers[index];
    const BakedLayer& layer = in_.layers[index];
    const size_t vertices = in_.surface.positions.size();
    std::vector<uint8_t> mask(vertices);
    std::vector<int16_t> bias(layer.bias.empty() ? 0 : vertices);
    bool full = true;
    for (size_t v = 0; v < vertices; ++v) {
      const uint32_t p = in_.surface.vertex_point[v];
      mask[v] = static_cast<uint8_t>(std::lround(std::clamp(layer.field.strength[p], 0.0f, 1.0f) * 255.0f));
      full &= mask[v] == 255;
      if (!bias.empty())
        bias[v] = static_cast<int16_t>(std::lround(std::clamp(layer.bias[p], -1.0f, 1.0f) * 32767.0f));
    }
    const auto parts = layer.parts.size() == in_.surface.parts.size()
                           ? Offset<flatbuffers::Vector<uint32_t>>()
                           : b_.CreateVector(layer.parts);
    const auto bias_stream = streamOf(padded(bias), 4);
    const auto mask_stream = full ? Offset<format::Stream>() : streamOf(padded(mask), 4);
    const bool by_axis = layer.axis && !layer.directions.empty();
    const auto axis = by_axis ? b_.CreateVector(glm::value_ptr(*layer.axis), 3) : 0;
    const auto direction_stream = by_axis ? 0 : streamOf(layer.directions, 4);
    std::vector<Offset<format::Driver>> drivers;
    for (const DriverRecipe& driver : recipe.drivers)
      for (size_t m = 0; m < in_.scene.rig.morphs.size(); ++m)
        if (in_.scene.rig.morphs[m].name == driver.morph) {
          std::vector<float> curve;
          for (const auto& [in, out] : driver.curve) {
            curve.push_back(static_cast<float>(in));
            curve.push_back(static_cast<float>(out));
          }
          const auto points = curve.empty() ? Offset<flatbuffers::Vector<float>>() : b_.CreateVector(curve);
          drivers.push_back(
              format::CreateDriver(b_, static_cast<uint32_t>(m), static_cast<float>(driver.gain), points));
          break;  // one mesh's target drives; its namesakes on other meshes move with it
        }
    return format::CreateLayer(
        b_, b_.CreateString(recipe.name), static_cast<uint8_t>(recipe.measure),
        static_cast<uint8_t>(recipe.response.curve), recipe.response.lambda, recipe.response.beta,
        recipe.response.stretch_lambda, recipe.response.stretch_beta, parts, bias_stream, mask_stream,
        direction_stream, static_cast<uint32_t>(index), b_.CreateVector(drivers), axis);
  }

  template <typename T>
  Offset<format::Stream> streamOf(const std::vector<T>& values, uint32_t stride) {
    return unlessEmpty(packed(values, stride));
  }

  Offset<format::Stream> unlessEmpty(const PackedStream& stream) {
    return stream.count == 0 ? Offset<format::Stream>() : writeStream(b_, stream);
  }

  Offset<flatbuffers::Vector<Offset<format::BaseMaps>>> writeBaseMaps() {
    std::vector<Offset<format::BaseMaps>> out;
    const auto uv = [&](const MaterialMap& map) {
      return map.uv == MaterialMap().uv ? 0 : b_.CreateVector(glm::value_ptr(map.uv), 6);
    };
    for (const BakedBaseMaps& maps : in_.base_maps) {
      const auto color = writeTexture(maps.color), normal = writeTexture(maps.normal);
      const auto color_uv = uv(maps.source.color), normal_uv = uv(maps.source.normal);
      const auto wrap = [](Wrap way) { return static_cast<format::Wrap>(way); };
      const auto &of_color = maps.source.color.wrap, &of_normal = maps.source.normal.wrap;
      out.push_back(format::CreateBaseMaps(b_, color, color_uv, maps.source.opaque_from, normal, normal_uv,
                                           wrap(of_color[0]), wrap(of_color[1]), wrap(of_normal[0]),
                                           wrap(of_normal[1])));
    }
    return out.empty() ? 0 : b_.CreateVector(out);
  }

  Offset<format::Texture> writeTexture(const EncodedTexture& texture) {
    if (texture.slices == 0) return {};
    const auto stream = unlessEmpty(textures_.extract(&texture).mapped());
    return format::CreateTexture(b_, static_cast<uint8_t>(texture.format), texture.width, texture.height,
                                 texture.slices, texture.levels, stream,
                                 static_cast<float>(texture.rms_error),
                                 static_cast<float>(texture.largest_error));
  }

  const PackInput& in_;
  std::map<const EncodedTexture*, PackedStream> textures_;
  std::vector<Morph> morphs_;
  double morph_error_ = 0.0;
  FlatBufferBuilder b_{1 << 20};
};

}  // namespace

std::vector<std::byte> writeAsset(const PackInput& input, uint32_t threads) {
  return Writer(input, threads).write();
}

}  // namespace furrow::pipeline
