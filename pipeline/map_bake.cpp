#include "pipeline/map_bake.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <optional>

#include "pipeline/error.h"
#include "pipeline/legible.h"
#include "pipeline/maps/synthesis.h"
#include "pipeline/maps/texel_map.h"

namespace furrow::pipeline {
namespace {

constexpr double kTexelsASpacing = 12.0;
constexpr uint32_t kOverlapSize = 256;
constexpr uint32_t kLeastSize = 64, kMostSize = 2048, kMostMaskSize = 512;
constexpr double kSpacingsAcross = 36.0;  // default: the squeezed region's diagonal holds this many ridges
constexpr double kSkinDepth = 0.16, kClothDepth = 0.24;  // of the spacing

struct Maps {
  Image normal, shading;
};

Image flat(uint32_t size, uint32_t channels) {
  return {size, size, channels, std::vector<float>(size_t{size} * size * channels, 0.0f)};
}

class MapBake {
 public:
  MapBake(const LayerInput& input, const Recipe& recipe, const std::vector<BakedLayer>& layers,
          uint32_t threads, std::vector<std::filesystem::path>& dependencies)
      : in_(input), recipe_(recipe), layers_(layers), threads_(threads), dependencies_(dependencies) {}

  std::vector<BakedTextureSet> bake() {
    std::map<uint32_t, BakedTextureSet>
        by_material;  // in material order, so that the result is the same on every run
    for (uint32_t p = 0; p < in_.surface.parts.size(); ++p) {
      if (!in_.surface.parts[p].has_uvs) continue;
      const uint32_t material = in_.scene.parts[in_.surface.parts[p].source_part].material;
      BakedTextureSet& set = by_material[material];
      set.parts.push_back(p);
      if (material < in_.scene.materials.size()) set.name = in_.scene.materials[material].name;
    }
    for (size_t l = 0; l < layers_.size(); ++l) {
      compress_.push_back(prepare(recipe_.layers[l].compress, layers_[l]));
      stretch_.push_back(prepare(recipe_.layers[l].stretch, layers_[l]));
    }
    std::vector<BakedTextureSet> sets;
    for (auto& [material, set] : by_material) join(sets, std::move(set));
    for (BakedTextureSet& set : sets) bakeSet(set);
    return sets;
  }

 private:
  // Adds a set to the first one that draws at about the same scale into other texels, or to the end.
  void join(std::vector<BakedTextureSet>& sets, BakedTextureSet set) {
    std::vector<bool> texels(size_t{kOverlapSize} * kOverlapSize);
    const TexelMap map = mapTexels(in_.surface, set.parts, kOverlapSize, 0);
    for (size_t i = 0; i < texels.size(); ++i) texels[i] = map.triangle[i] != kNoIndex;
    const double length = lengthOfUv(set);
    for (size_t s = 0; s < sets.size(); ++s) {
      const double other = lengthOfUv(sets[s]);
      if (length > 1.5 * other || other > 1.5 * length) continue;
      size_t overlap = 0;
      for (size_t i = 0; i < texels.size(); ++i) overlap += texels[i] && taken_[s][i];
      if (overlap > texels.size() / 1000) continue;
      for (size_t i = 0; i < texels.size(); ++i) taken_[s][i] = taken_[s][i] || texels[i];
      sets[s].parts.insert(sets[s].parts.end(), set.parts.begin(), set.parts.end());
      return;
    }
    sets.push_back(std::move(set));
    taken_.push_back(std::move(texels));
  }

  struct Source {
    std::optional<SynthesisSettings> settings;
    std::shared_ptr<LayerField> field;  // outlives the synthesis
    std::shared_ptr<Synthesis> synthesis;
  };

  Source prepare(const Map& map, const BakedLayer& layer) const {
    Source source;
    const auto* wanted = std::get_if<MapSynthesized>(&map);
    if (!wanted || !wanted->preset) return source;
    source.settings.emplace();
    source.settings->preset = *wanted->preset;
    source.settings->spacing = wanted->spacing;
    source.settings->depth = wanted->depth;
    source.settings->seed = wanted->seed;
    // The mask fades the layer when it is drawn; the map itself is at full depth wherever the mask reaches.
    source.field = std::make_shared<LayerField>(layer.field);
    for (float& strength : source.field->strength) strength = strength > 0.0f ? 1.0f : 0.0f;
    source.synthesis = std::make_shared<Synthesis>(in_.surface, *source.field, *source.settings);
    return source;
  }

  // Whether the layer shows on a triangle of the set; a point that it merely shares with a neighbour's part
  // does not count.
  bool reaches(const BakedLayer& layer, const BakedTextureSet& set) const {
    for (uint32_t part : set.parts)
      for (uint32_t t = in_.surface.parts[part].triangle_begin; t < in_.surface.parts[part].triangle_end;
           ++t) {
        const glm::uvec3 p = in_.surface.trianglePoints(t);
        const auto shows = [&](uint32_t point) { return layer.field.strength[point] >= 1.0f / 255.0f; };
        if (layer.covered[t] && (shows(p.x) || shows(p.y) || shows(p.z))) return true;
      }
    return false;
  }

  // Root-space length of one unit of UV.
  double lengthOfUv(const BakedTextureSet& set) const {
    double area = 0.0, uv_area = 0.0;
    for (uint32_t part : set.parts)
      for (uint32_t t = in_.surface.parts[part].triangle_begin; t < in_.surface.parts[part].triangle_end;
           ++t) {
        const glm::uvec3 v = in_.surface.triangles[t];
        const glm::dvec3 a = in_.surface.positions[v.x];
        area += glm::length(glm::cross(glm::dvec3(in_.surface.positions[v.y]) - a,
                                       glm::dvec3(in_.surface.positions[v.z]) - a));
        const glm::dvec2 s = in_.surface.uvs[v.x], e = glm::dvec2(in_.surface.uvs[v.y]) - s,
                         f = glm::dvec2(in_.surface.uvs[v.z]) - s;
        uv_area += std::abs(e.x * f.y - e.y * f.x);
      }
    return uv_area > 0.0 ? std::sqrt(area / uv_area) : 0.0;
  }

  uint32_t mapSize(const BakedTextureSet& set) const {
    const double length = lengthOfUv(set);
    double texels = kLeastSize;
    for (const auto* sources : {&compress_, &stretch_})
      for (size_t l = 0; l < sources->size(); ++l)
        if ((*sources)[l].settings && reaches(layers_[l], set))
          texels = std::max(texels, kTexelsASpacing * length / (*sources)[l].settings->spacing);
    for (const LayerRecipe& layer : recipe_.layers)
      for (const Map* map : {&layer.compress, &layer.stretch})
        if (std::holds_alternative<MapNormal>(*map) || std::holds_alternative<MapHeight>(*map))
          texels = std::max(texels, 1024.0);
    const uint32_t most = recipe_.map_size ? std::bit_floor(recipe_.map_size) : kMostSize;
    return std::min(most, std::bit_ceil(static_cast<uint32_t>(std::min(texels, 16384.0))));
  }

  Image read(const std::filesystem::path& file, uint32_t least_channels) {
    dependencies_.push_back(file);
    Image image = readImage(file);
    if (image.channels < least_channels)
      throw Error(Exit::kBadData, file.string(), "it has " + std::to_string(image.channels) + " channels",
                  "use an image with " + std::to_string(least_channels));
    return image;
  }

  // An authored normal map: renormalised, x and y kept.
  Image normalsOf(const std::filesystem::path& file, uint32_t size) {
    const Image source = resize(read(file, 3), size, size);
    Image out = flat(size, 2);
    for (size_t i = 0; i < size_t{size} * size; ++i) {
      const glm::vec3 n =
          glm::vec3(source.pixels[i * source.channels], source.pixels[i * source.channels + 1],
                    source.pixels[i * source.channels + 2]) *
              2.0f -
          1.0f;
      const float length = glm::length(n);
      if (!(length > 0.1f)) continue;
      out.pixels[2 * i] = n.x / length;
      out.pixels[2 * i + 1] = n.y / length;
    }
    return out;
  }

  // Slopes of an authored height map, x along +u and y along -v, which is up in the image.
  Maps mapsFromHeight(const std::filesystem::path& file, uint32_t size, double depth, double length_of_uv) {
    const Image source = resize(read(file, 1), size, size);
    Maps maps{flat(size, 2), flat(size, 1)};
    const double texel = length_of_uv / size;
    const auto height = [&](uint32_t x, uint32_t y) {
      return double{source.at(x % size, y % size)[0]} * depth;
    };
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const double dx = texel > 0.0 ? (height(x + 1, y) - height(x + size - 1, y)) / (2.0 * texel) : 0.0;
        const double dy = texel > 0.0 ? (height(x, y + size - 1) - height(x, y + 1)) / (2.0 * texel) : 0.0;
        const double length = std::sqrt(dx * dx + dy * dy + 1.0);
        maps.normal.at(x, y)[0] = static_cast<float>(-dx / length);
        maps.normal.at(x, y)[1] = static_cast<float>(-dy / length);
        maps.shading.at(x, y)[0] = 0.5f * (1.0f - std::clamp(source.at(x, y)[0], 0.0f, 1.0f));
      }
    return maps;
  }

  void bakeSet(BakedTextureSet& set) {
    set.compress_slice.assign(layers_.size(), kAbsent);
    set.stretch_slice.assign(layers_.size(), kAbsent);
    const uint32_t size = mapSize(set);
    std::vector<Image> normals, shading;
    for (size_t l = 0; l < layers_.size(); ++l) {
      if (!reaches(layers_[l], set)) continue;
      const LayerRecipe& layer = recipe_.layers[l];
      const auto add = [&](const Map& map, const Source& source,
                           const std::optional<std::filesystem::path>& authored_shading, uint32_t& slice) {
        Maps maps;
        if (const auto* normal = std::get_if<MapNormal>(&map)) {
          maps = {normalsOf(normal->texture, size), flat(size, 1)};
        } else if (const auto* height = std::get_if<MapHeight>(&map)) {
          maps = mapsFromHeight(height->texture, size, height->depth, lengthOfUv(set));
        } else if (source.synthesis) {
          SynthesizedMaps drawn = source.synthesis->draw(set.parts, size, threads_);
          maps = {std::move(drawn.normal), std::move(drawn.shading)};
        } else {
          return;
        }
        if (authored_shading) {
          const Image image = resize(read(*authored_shading, 1), size, size);
          for (size_t i = 0; i < size_t{size} * size; ++i)
            maps.shading.pixels[i] = image.pixels[i * image.channels];
        }
        slice = static_cast<uint32_t>(normals.size());
        normals.push_back(std::move(maps.normal));
        shading.push_back(std::move(maps.shading));
      };
      add(layer.compress, compress_[l], layer.compress_shading, set.compress_slice[l]);
      add(layer.stretch, stretch_[l], layer.stretch_shading, set.stretch_slice[l]);
    }
    set.normals = encode(TextureFormat::kBc5, normals);
    set.shading = encode(TextureFormat::kBc4, shading);
    if (!normals.empty()) bakeMasks(set, std::min(size, kMostMaskSize));
  }

  void bakeMasks(BakedTextureSet& set, uint32_t size) {
    const TexelMap texels = mapTexels(in_.surface, set.parts, size, size / 64 + 2);
    std::vector<Image> slices((layers_.size() + 3) / 4, flat(size, 4));
    for (size_t l = 0; l < layers_.size(); ++l) {
      Image& slice = slices[l / 4];
      const size_t channel = l % 4;
      if (const auto* texture = std::get_if<MaskTexture>(&recipe_.layers[l].mask)) {
        const Image image = resize(readImage(texture->texture), size, size);
        for (size_t i = 0; i < size_t{size} * size; ++i)
          slice.pixels[4 * i + channel] = image.pixels[i * image.channels + texture->channel];
        continue;
      }
      for (size_t i = 0; i < size_t{size} * size; ++i) {
        if (texels.triangle[i] == kNoIndex) continue;
        const glm::uvec3 p = in_.surface.trianglePoints(texels.triangle[i]);
        const glm::vec2 b = texels.barycentric[i];
        const std::vector<float>& strength = layers_[l].field.strength;
        slice.pixels[4 * i + channel] = std::clamp(
            strength[p.x] * (1.0f - b.x - b.y) + strength[p.y] * b.x + strength[p.z] * b.y, 0.0f, 1.0f);
      }
    }
    set.masks = encode(TextureFormat::kRgba8, slices);
  }

  const LayerInput& in_;
  const Recipe& recipe_;
  const std::vector<BakedLayer>& layers_;
  uint32_t threads_;
  std::vector<std::filesystem::path>& dependencies_;
  std::vector<Source> compress_, stretch_;
  std::vector<std::vector<bool>> taken_;  // a set: texels of kOverlapSize x kOverlapSize its charts cover
};

// Diagonal of what the layer reaches; 0: nothing.
double reachOf(const Surface& surface, const BakedLayer& layer) {
  glm::vec3 lowest(INFINITY), highest(-INFINITY);
  for (size_t p = 0; p < layer.field.strength.size(); ++p) {
    if (layer.field.strength[p] < 0.1f) continue;
    lowest = glm::min(lowest, surface.point_positions[p]);
    highest = glm::max(highest, surface.point_positions[p]);
  }
  return lowest.x <= highest.x ? double{glm::length(highest - lowest)} : 0.0;
}

}  // namespace

void resolveMaps(const LayerInput& input, const BakedLayer& layer, LayerRecipe& recipe) {
  const double spacing = legible(reachOf(input.surface, layer) / kSpacingsAcross);
  if (!(spacing > 0.0)) return;
  const Preset preset = input.squeeze.by_morphs > 0.0 ? Preset::kSkin : Preset::kCloth;
  const auto depth = [](Preset p, double s) {
    return legible(s * (p == Preset::kSkin ? kSkinDepth : kClothDepth));
  };
  for (Map* map : {&recipe.compress, &recipe.stretch}) {
    if (auto* height = std::get_if<MapHeight>(map); height && height->depth == 0.0)
      height->depth = depth(preset, spacing);
    if (auto* wanted = std::get_if<MapSynthesized>(map)) {
      if (!wanted->preset) wanted->preset = preset;
      if (wanted->spacing == 0.0) wanted->spacing = spacing;
      if (wanted->depth == 0.0) wanted->depth = depth(*wanted->preset, wanted->spacing);
    }
  }
}

std::vector<BakedTextureSet> bakeMaps(const LayerInput& input, const Recipe& recipe,
                                      const std::vector<BakedLayer>& layers, uint32_t threads,
                                      std::vector<std::filesystem::path>& dependencies) {
  return MapBake(input, recipe, layers, threads, dependencies).bake();
}

}  // namespace furrow::pipeline
