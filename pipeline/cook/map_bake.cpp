#include "pipeline/cook/map_bake.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>

#include "pipeline/content_key.h"
#include "pipeline/error.h"
#include "pipeline/legible.h"
#include "pipeline/maps/authored.h"
#include "pipeline/maps/synthesis.h"
#include "pipeline/maps/texel_map.h"
#include "pipeline/parallel.h"

namespace furrow::pipeline {
namespace {

constexpr double kTexelsASpacing = 12.0;
constexpr uint32_t kOverlapSize = 256;
// Of the area of all charts, what may lie on others unsaid.
constexpr double kMostShared = 0.05;
constexpr uint32_t kSizeStep = 64, kMostSize = 2048, kDerivedMaskSize = 512;
constexpr uint32_t kWindowMargin = 2;     // mask texels; bilinear filtering reads one beyond the mask
constexpr double kNearlyWhole = 0.9;      // of a period: not worth a window
constexpr double kSpacingsAcross = 36.0;  // default: the squeezed region's diagonal holds this many ridges
constexpr double kFlat = 0.9;             // of a sheet's area, the largest shadow that it casts at least
constexpr float kFaintest = 0.2f;         // depth of a synthesised map where the clips squeeze least
constexpr double kFewestTexels = 4.0;     // a spacing, of kTexelsASpacing in the mean
constexpr double kMostCoarse = 0.35;      // of what a layer covers, what may have fewer

struct PresetDefaults {
  double spacing, depth;  // of the default spacing; of the spacing
};

PresetDefaults defaultsOf(Preset preset) {
  switch (preset) {
    case Preset::kSkin:
      return {1.0, 0.16};
    case Preset::kSkinFine:
      return {0.4, 0.1};
    case Preset::kCloth:
      return {1.0, 0.24};
    case Preset::kClothPuckers:
      return {0.6, 0.22};
  }
  return {};
}

// Texels used along one axis, which repeats: the complement of the longest gap.
struct Run {
  uint32_t begin = 0, count = 0;
};

Run usedRun(const std::vector<bool>& used) {
  const auto size = static_cast<uint32_t>(used.size());
  Run gap;
  uint32_t length = 0;
  for (uint32_t i = 0; i < 2 * size; ++i) {
    length = used[i % size] ? 0 : std::min(length + 1, size);
    if (length > gap.count) gap = {i + 1 - length, length};
  }
  const uint32_t count = size - gap.count + 2 * kWindowMargin;
  if (count >= kNearlyWhole * size) return {0, size};
  return {(gap.begin + gap.count + size - kWindowMargin) % size, count};
}

// By all that a pattern depends on but the surface.
std::string patternKey(const SynthesisSettings& settings, const LayerField& field) {
  std::string key = std::to_string(static_cast<int>(settings.preset)) + ' ' + std::to_string(settings.seed);
  for (const double value : {settings.spacing, settings.depth})
    key += ' ' + std::to_string(std::bit_cast<uint64_t>(value));
  for (const auto bytes :
       {std::as_bytes(std::span(field.direction)), std::as_bytes(std::span(field.confidence)),
        std::as_bytes(std::span(field.strength))})
    key += ' ' + contentKey(bytes);
  return key;
}

}  // namespace

struct Pattern {
  Pattern(std::string of, const Surface& surface, LayerField of_layer, const SynthesisSettings& wanted)
      : key(std::move(of)),
        settings(wanted),
        field(std::move(of_layer)),
        synthesis(surface, field, settings) {}

  const std::string key;
  const SynthesisSettings settings;
  const LayerField field;
  const Synthesis synthesis;
};

namespace {

class MapBake {
 public:
  MapBake(const LayerInput& input, const Recipe& recipe, const std::vector<BakedLayer>& layers,
          uint32_t threads, std::vector<std::filesystem::path>& dependencies,
          std::vector<std::string>& warnings, Patterns& known)
      : in_(input),
        recipe_(recipe),
        layers_(layers),
        threads_(threads),
        dependencies_(dependencies),
        warnings_(warnings),
        known_(known) {}

  std::vector<BakedTextureSet> bake() {
    std::map<uint32_t, BakedTextureSet> by_material;  // in order, so that every run gives the same
    for (uint32_t p = 0; p < in_.surface.parts.size(); ++p) {
      if (!in_.surface.parts[p].has_uvs) continue;
      const uint32_t material = in_.scene.parts[in_.surface.parts[p].source_part].material;
      BakedTextureSet& set = by_material[material];
      set.parts.push_back(p);
      if (material < in_.scene.materials.size()) set.name = in_.scene.materials[material].name;
    }
    std::erase_if(by_material, [&](const auto& entry) { return drawnIn(entry.second).empty(); });
    if (by_material.empty()) return {};
    peaks_ = pointPeaks(in_.surface, in_.squeeze);
    compress_.resize(layers_.size());
    stretch_.resize(layers_.size());
    parallelFor(static_cast<uint32_t>(layers_.size()), threads_, [&](uint32_t l) {
      compress_[l] = prepare(recipe_.layers[l].compress, layers_[l], recipe_.layers[l].name);
      stretch_[l] = prepare(recipe_.layers[l].stretch, layers_[l], recipe_.layers[l].name);
    });
    known_.clear();
    for (const auto& patterns : {compress_, stretch_})
      for (const auto& pattern : patterns)
        if (pattern) known_.emplace(pattern->key, pattern);
    std::vector<BakedTextureSet> sets;
    for (auto& [material, set] : by_material) join(sets, std::move(set));
    for (BakedTextureSet& set : sets) bakeSet(set);
    return sets;
  }

 private:
  // Adds a set to the first one that draws at about the same scale into other texels, or to the end.
  void join(std::vector<BakedTextureSet>& sets, BakedTextureSet set) {
    std::vector<bool> texels(size_t{kOverlapSize} * kOverlapSize);
    const TexelMap map =
        mapTexels(in_.surface, chartsOf(in_.surface, set.parts), {kOverlapSize, kOverlapSize}, 0, threads_);
    for (size_t i = 0; i < texels.size(); ++i) texels[i] = map.triangle[i] != kNoIndex;
    const double covered = static_cast<double>(std::count(texels.begin(), texels.end(), true));
    const auto [length, area] = sizeOfUvs(set);
    const double shared = 1.0 - covered / (area * kOverlapSize * kOverlapSize);
    if (area == 0.0)
      warn(set, " have no area: it gets weights, but no wrinkle maps; unwrap it");
    else if (shared > kMostShared)
      warn(set, " overlap: " + std::to_string(static_cast<int>(100.0 * shared)) +
                    "% of them show the wrinkles of another place; unwrap them apart");
    for (size_t s = 0; s < sets.size(); ++s) {
      const double other = sizeOfUvs(sets[s]).length;
      if (length > 1.5 * other || other > 1.5 * length) continue;
      const size_t most = texels.size() / 1000;
      size_t overlap = 0;
      for (size_t i = 0; i < texels.size() && overlap <= most; ++i) overlap += texels[i] && taken_[s][i];
      if (overlap > most) continue;
      for (size_t i = 0; i < texels.size(); ++i) taken_[s][i] = taken_[s][i] || texels[i];
      sets[s].parts.insert(sets[s].parts.end(), set.parts.begin(), set.parts.end());
      return;
    }
    sets.push_back(std::move(set));
    taken_.push_back(std::move(texels));
  }

  void warn(const BakedTextureSet& set, const std::string& what) {
    warnings_.push_back("the UVs of " + (set.name.empty() ? "a mesh" : "material \"" + set.name + "\"") +
                        what);
  }

  std::shared_ptr<const Pattern> prepare(const Map& map, const BakedLayer& layer, const std::string& name) {
    const auto* wanted = std::get_if<MapSynthesized>(&map);
    if (!wanted || !wanted->preset) return nullptr;
    const SynthesisSettings settings{*wanted->preset, wanted->spacing, wanted->depth, wanted->seed};
    LayerField field = layer.field;
    deepen(field.strength);
    const std::string key = patternKey(settings, field);
    if (const auto found = known_.find(key); found != known_.end()) return found->second;
    try {
      return std::make_shared<const Pattern>(key, in_.surface, std::move(field), settings);
    } catch (const std::length_error& error) {
      throw Error(Exit::kBadData, in_.recipe_file, "layer \"" + name + "\": " + error.what(),
                  "give a larger spacing or a smaller mask");
    }
  }

  // From a mask to the depth of the map: full where the clips squeeze the layer most, less where they squeeze
  // it less, the same everywhere if they do not squeeze it. The mask fades the layer when it is drawn.
  void deepen(std::vector<float>& strength) const {
    std::vector<float> peaks;
    for (size_t p = 0; p < strength.size(); ++p)
      if (strength[p] >= 0.1f && peaks_[p] > 0.0f) peaks.push_back(peaks_[p]);
    float most = 0.0f;
    if (!peaks.empty()) {
      const auto at = peaks.begin() + static_cast<std::ptrdiff_t>(peaks.size() * 3 / 4);
      std::nth_element(peaks.begin(), at, peaks.end());
      most = *at;
    }
    for (size_t p = 0; p < strength.size(); ++p) {
      const float share = most > 0.0f ? std::min(peaks_[p] / most, 1.0f) : 1.0f;
      strength[p] = strength[p] > 0.0f ? kFaintest + (1.0f - kFaintest) * share * std::sqrt(share) : 0.0f;
    }
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

  // The layers with a map that show on the set.
  std::vector<size_t> drawnIn(const BakedTextureSet& set) const {
    std::vector<size_t> drawn;
    for (size_t l = 0; l < layers_.size(); ++l) {
      const LayerRecipe& recipe = recipe_.layers[l];
      const bool has_map = !std::holds_alternative<MapNone>(recipe.compress) ||
                           !std::holds_alternative<MapNone>(recipe.stretch);
      if (has_map && reaches(layers_[l], set)) drawn.push_back(l);
    }
    return drawn;
  }

  struct Areas {  // of a triangle, twice
    double area = 0.0, uv_area = 0.0;
  };
  Areas areasOf(uint32_t t) const {
    const glm::uvec3 v = in_.surface.triangles[t];
    const glm::dvec3 a = in_.surface.positions[v.x];
    const glm::dvec2 s = in_.surface.uvs[v.x], e = glm::dvec2(in_.surface.uvs[v.y]) - s,
                     f = glm::dvec2(in_.surface.uvs[v.z]) - s;
    return {glm::length(glm::cross(glm::dvec3(in_.surface.positions[v.y]) - a,
                                   glm::dvec3(in_.surface.positions[v.z]) - a)),
            std::abs(e.x * f.y - e.y * f.x)};
  }

  struct UvSize {
    double length = 0.0;  // of one unit of UV in root space
    double area = 0.0;    // of all triangles together, in UV
  };
  UvSize sizeOfUvs(const BakedTextureSet& set) const {
    double area = 0.0, uv_area = 0.0;
    for (uint32_t part : set.parts)
      for (uint32_t t = in_.surface.parts[part].triangle_begin; t < in_.surface.parts[part].triangle_end;
           ++t) {
        const Areas of = areasOf(t);
        area += of.area;
        uv_area += of.uv_area;
      }
    return {uv_area > 0.0 ? std::sqrt(area / uv_area) : 0.0, 0.5 * uv_area};
  }

  const ByteImage* maskImage(size_t layer) const {
    const auto* texture = std::get_if<MaskTexture>(&recipe_.layers[layer].mask);
    return texture ? &in_.masks.at(texture->texture) : nullptr;
  }

  uint32_t mostTexels() const { return recipe_.map_size ? recipe_.map_size : kMostSize; }

  // The masks of all layers, as large as the largest image among them, and where on the surface they lie.
  struct Masks {
    std::vector<ByteImage> slices;  // four layers each
    TexelMap texels;
    Coverage coverage;
  };

  Masks drawMasks(const Charts& charts) const {
    TexelGrid grid;
    for (size_t l = 0; l < layers_.size(); ++l) {
      const ByteImage* image = maskImage(l);
      grid.width = std::max(grid.width, image ? image->width : kDerivedMaskSize);
      grid.height = std::max(grid.height, image ? image->height : kDerivedMaskSize);
    }
    grid.width = std::min(grid.width, mostTexels());
    grid.height = std::min(grid.height, mostTexels());
    Masks masks;
    masks.texels = mapTexels(in_.surface, charts, grid, 2, threads_);
    masks.coverage = coverageOf(masks.texels);
    std::array<ByteImage, 4> drawn;
    for (size_t first = 0; first < layers_.size(); first += 4) {
      std::array<MaskChannel, 4> channels;
      for (size_t c = 0; c < 4 && first + c < layers_.size(); ++c) {
        if (const ByteImage* image = maskImage(first + c)) {
          channels[c] = {image, std::get<MaskTexture>(recipe_.layers[first + c].mask).channel};
        } else {
          drawn[c] = drawMask(masks.texels, layers_[first + c].field.strength);
          channels[c] = {&drawn[c], 0};
        }
      }
      masks.slices.push_back(packMasks(channels, grid.width, grid.height, threads_));
    }
    return masks;
  }

  ByteImage drawMask(const TexelMap& texels, const std::vector<float>& strength) const {
    Image mask{texels.grid.width, texels.grid.height, 1, std::vector<float>(texels.triangle.size(), 0.0f)};
    for (size_t i = 0; i < texels.triangle.size(); ++i) {
      if (texels.triangle[i] == kNoIndex) continue;
      const glm::uvec3 p = in_.surface.trianglePoints(texels.triangle[i]);
      const glm::vec2 b = texels.barycentric[i];
      mask.pixels[i] = strength[p.x] * (1.0f - b.x - b.y) + strength[p.y] * b.x + strength[p.z] * b.y;
    }
    return toBytes(mask);
  }

  static Coverage coverageOf(const TexelMap& texels) {
    Coverage coverage(texels.triangle.size());
    for (size_t i = 0; i < coverage.size(); ++i) coverage[i] = texels.triangle[i] != kNoIndex;
    return coverage;
  }

  // The part of UV space in which a layer's mask lets it be seen.
  TexelGrid windowOf(const Masks& masks, size_t layer) const {
    const ByteImage& slice = masks.slices[layer / 4];
    std::vector<bool> columns(slice.width), rows(slice.height);
    for (uint32_t y = 0; y < slice.height; ++y)
      for (uint32_t x = 0; x < slice.width; ++x) {
        const uint32_t triangle = masks.texels.triangle[size_t{y} * slice.width + x];
        if (triangle == kNoIndex || !layers_[layer].covered[triangle] || slice.at(x, y)[layer % 4] == 0)
          continue;
        columns[x] = rows[y] = true;
      }
    const Run across = usedRun(columns), down = usedRun(rows);
    return {
        0,
        0,
        {across.begin / static_cast<double>(slice.width), down.begin / static_cast<double>(slice.height)},
        {across.count / static_cast<double>(slice.width), down.count / static_cast<double>(slice.height)}};
  }

  // One slice to be drawn.
  struct Pose {
    size_t layer = 0;
    const Map* map = nullptr;
    const MapFinish* finish = nullptr;
    const Pattern* pattern = nullptr;
    TexelGrid grid;
    Image image;             // authored slopes or heights
    glm::dvec2 wanted{0.0};  // texels of the window
  };

  Image read(const std::filesystem::path& file) {
    dependencies_.push_back(file);
    return readImage(file);
  }

  Pose pose(size_t layer, bool stretch, const TexelGrid& window, double length_of_uv) {
    const LayerRecipe& recipe = recipe_.layers[layer];
    Pose pose{layer,
              stretch ? &recipe.stretch : &recipe.compress,
              stretch ? &recipe.stretch_finish : &recipe.compress_finish,
              stretch ? stretch_[layer].get() : compress_[layer].get(),
              window,
              {},
              {}};
    if (const auto* normal = std::get_if<MapNormal>(pose.map)) {
      dependencies_.push_back(normal->texture);
      pose.image = readNormals(normal->texture, normal->green);
    } else if (const auto* height = std::get_if<MapHeight>(pose.map)) {
      dependencies_.push_back(height->texture);
      pose.image = readHeights(height->texture);
    } else if (pose.pattern) {
      pose.wanted = window.extent * (kTexelsASpacing * length_of_uv / pose.pattern->settings.spacing);
    }
    if (pose.image.width > 0) pose.wanted = window.extent * glm::dvec2(pose.image.width, pose.image.height);
    return pose;
  }

  // Whether the charts differ so much in scale that much of the layer would show its wrinkles as shards.
  bool isTooUneven(const BakedTextureSet& set, size_t layer, double length_of_uv) {
    const std::vector<float>& strength = layers_[layer].field.strength;
    const double fewest = kFewestTexels / (kTexelsASpacing * length_of_uv);  // UV a length
    double area = 0.0, coarse = 0.0;
    for (uint32_t part : set.parts)
      for (uint32_t t = in_.surface.parts[part].triangle_begin; t < in_.surface.parts[part].triangle_end;
           ++t) {
        const glm::uvec3 p = in_.surface.trianglePoints(t);
        if (!layers_[layer].covered[t] || strength[p.x] + strength[p.y] + strength[p.z] == 0.0f) continue;
        const Areas of = areasOf(t);
        area += of.area;
        if (of.uv_area < fewest * fewest * of.area) coarse += of.area;
      }
    if (coarse <= kMostCoarse * area) return false;
    warn(set, " are too uneven for layer \"" + recipe_.layers[layer].name +
                  "\": " + std::to_string(static_cast<int>(100.0 * coarse / area)) +
                  "% of it has less than a third of the texels that wrinkles take; it gets weights, but no "
                  "wrinkle map; unwrap the mesh more evenly");
    return true;
  }

  WrinkleMaps draw(const Pose& pose, const TexelMap& texels) {
    WrinkleMaps maps;
    if (std::holds_alternative<MapNormal>(*pose.map)) {
      maps = mapsFromSlopes(pose.image, texels.grid);
    } else if (const auto* height = std::get_if<MapHeight>(pose.map)) {
      maps = mapsFromHeights(pose.image, in_.surface, texels, height->depth);
    } else {
      SynthesizedMaps drawn = pose.pattern->synthesis.draw(texels, threads_);
      maps = {std::move(drawn.normal), std::move(drawn.shading)};
    }
    if (pose.finish->limit < 1.0) limitNormals(maps.normal, static_cast<float>(pose.finish->limit));
    if (pose.finish->light) maps.shading = litShading(maps.normal, in_.surface, texels, *pose.finish->light);
    if (pose.finish->shading) {
      const Image image = resize(read(*pose.finish->shading), texels.grid.width, texels.grid.height,
                                 texels.grid.low, texels.grid.extent);
      for (size_t i = 0; i < maps.shading.pixels.size(); ++i)
        maps.shading.pixels[i] = image.pixels[i * image.channels];
    }
    return maps;
  }

  void bakeSet(BakedTextureSet& set) {
    set.compress_slice.assign(layers_.size(), kAbsent);
    set.stretch_slice.assign(layers_.size(), kAbsent);
    const std::vector<size_t> drawn = drawnIn(set);
    const Charts charts = chartsOf(in_.surface, set.parts);
    const Masks masks = drawMasks(charts);
    const double length_of_uv = sizeOfUvs(set).length;
    std::vector<Pose> poses;
    glm::dvec2 wanted(kSizeStep);
    for (const size_t l : drawn) {
      const TexelGrid window = windowOf(masks, l);
      for (const bool stretch : {false, true}) {
        Pose next = pose(l, stretch, window, length_of_uv);
        if (next.wanted == glm::dvec2(0.0)) continue;
        if (next.pattern && isTooUneven(set, l, length_of_uv)) continue;
        (stretch ? set.stretch_slice : set.compress_slice)[l] = static_cast<uint32_t>(poses.size());
        wanted = glm::max(wanted, next.wanted);
        poses.push_back(std::move(next));
      }
    }
    if (poses.empty()) return;

    const auto side = [&](double texels) {
      const auto steps = static_cast<uint32_t>(std::ceil(std::min(texels, 16384.0) / kSizeStep));
      return std::max(std::min(steps * kSizeStep, mostTexels() / 4 * 4), 4u);
    };
    std::vector<Image> normals, shading;
    std::vector<Coverage> coverage;
    TexelMap texels;
    for (Pose& pose : poses) {
      pose.grid.width = side(wanted.x);
      pose.grid.height = side(wanted.y);
      if (normals.empty() || texels.grid.low != pose.grid.low || texels.grid.extent != pose.grid.extent)
        texels = mapTexels(in_.surface, charts, pose.grid,
                           std::max({4u, pose.grid.width / 128, pose.grid.height / 128}), threads_);
      WrinkleMaps maps = draw(pose, texels);
      pose.image = {};
      normals.push_back(std::move(maps.normal));
      shading.push_back(std::move(maps.shading));
      coverage.push_back(coverageOf(texels));
      set.windows.push_back(glm::vec4(pose.grid.low, 1.0 / pose.grid.extent));
    }
    set.normals = encode(TextureFormat::kBc5, normals, coverage, threads_);
    set.shading = encode(TextureFormat::kBc4, shading, coverage, threads_);
    set.masks =
        encodeBytes(masks.slices, std::vector<Coverage>(masks.slices.size(), masks.coverage), threads_);
  }

  const LayerInput& in_;
  const Recipe& recipe_;
  const std::vector<BakedLayer>& layers_;
  uint32_t threads_;
  std::vector<std::filesystem::path>& dependencies_;
  std::vector<std::string>& warnings_;
  Patterns& known_;
  std::vector<std::shared_ptr<const Pattern>> compress_, stretch_;
  std::vector<float> peaks_;              // a point
  std::vector<std::vector<bool>> taken_;  // a set: texels of kOverlapSize x kOverlapSize its charts cover
};

struct Box {
  glm::vec3 lowest{INFINITY}, highest{-INFINITY};

  void add(const glm::vec3& p) {
    lowest = glm::min(lowest, p);
    highest = glm::max(highest, p);
  }
  double diagonal() const { return lowest.x <= highest.x ? double{glm::length(highest - lowest)} : 0.0; }
};

// What the layer reaches, and what of that morph targets squeeze; none of it is a face where all that the
// layer lies on is a flat sheet.
struct Reach {
  Box all, face;
  bool flat = false;
};

Reach reachOf(const LayerInput& input, const BakedLayer& layer) {
  const std::vector<uint8_t>& by_morph = input.squeeze.by_morph;  // empty if no layer asks for the squeeze
  const std::vector<glm::vec3>& at = input.surface.point_positions;
  Reach reach;
  glm::dvec3 sum(0.0);
  double area = 0.0;
  for (size_t t = 0; t < input.surface.triangles.size(); ++t) {
    const glm::uvec3 corners = input.surface.trianglePoints(t);
    if (layer.covered[t]) {
      const glm::dvec3 a = at[corners.x], b = at[corners.y], c = at[corners.z];
      const glm::dvec3 normal = glm::cross(b - a, c - a);
      sum += normal;
      area += glm::length(normal);
    }
    for (const uint32_t p : {corners.x, corners.y, corners.z}) {
      if (layer.field.strength[p] < 0.1f) continue;
      reach.all.add(at[p]);
      if (!by_morph.empty() && by_morph[t]) reach.face.add(at[p]);
    }
  }
  reach.flat = glm::length(sum) > kFlat * area;
  return reach;
}

}  // namespace

void resolveMaps(const LayerInput& input, const BakedLayer& layer, LayerRecipe& recipe) {
  // Where there is a face its lines set the measure: those of a whole body would be as wide as its mouth. A
  // flat sheet is none, whatever moves it.
  const Reach reach = reachOf(input, layer);
  const bool face = reach.face.diagonal() > 0.0 && !reach.flat;
  const double spacing = legible((face ? reach.face : reach.all).diagonal() / kSpacingsAcross);
  if (!(spacing > 0.0)) return;
  const Preset preset = face ? Preset::kSkin : Preset::kCloth;
  for (Map* map : {&recipe.compress, &recipe.stretch}) {
    if (auto* height = std::get_if<MapHeight>(map); height && height->depth == 0.0)
      height->depth = legible(spacing * defaultsOf(preset).depth);
    if (auto* wanted = std::get_if<MapSynthesized>(map)) {
      if (!wanted->preset) wanted->preset = preset;
      const PresetDefaults defaults = defaultsOf(*wanted->preset);
      if (wanted->spacing == 0.0) wanted->spacing = legible(spacing * defaults.spacing);
      if (wanted->depth == 0.0) wanted->depth = legible(wanted->spacing * defaults.depth);
    }
  }
}

std::vector<BakedTextureSet> bakeMaps(const LayerInput& input, const Recipe& recipe,
                                      const std::vector<BakedLayer>& layers, uint32_t threads,
                                      std::vector<std::filesystem::path>& dependencies,
                                      std::vector<std::string>& warnings, Patterns& known) {
  return MapBake(input, recipe, layers, threads, dependencies, warnings, known).bake();
}

}  // namespace furrow::pipeline
