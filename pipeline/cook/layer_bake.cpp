#include "pipeline/cook/layer_bake.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "direction_codec.h"
#include "pipeline/bake/image_directions.h"
#include "pipeline/bake/rest_view.h"
#include "pipeline/content_key.h"
#include "pipeline/error.h"
#include "pipeline/maps/authored.h"
#include "pipeline/scene/posing.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

// Peak squeeze at which the automatic mask starts and is full.
constexpr float kFadeBegin = 0.03f, kFadeEnd = 0.15f;
constexpr int kMaskBlurs = 4;
constexpr float kUnsure = 0.25f;  // confidence below it counts as low

void blur(const Surface& surface, int times, std::vector<float>& values) {
  for (int i = 0; i < times; ++i) {
    std::vector<float> sum(values.size(), 0.0f), count(values.size(), 0.0f);
    for (size_t t = 0; t < surface.triangles.size(); ++t) {
      const glm::uvec3 p = surface.trianglePoints(t);
      const float mean = (values[p.x] + values[p.y] + values[p.z]) / 3.0f;
      for (int c = 0; c < 3; ++c) {
        sum[p[c]] += mean;
        count[p[c]] += 1.0f;
      }
    }
    for (size_t p = 0; p < values.size(); ++p)
      if (count[p] > 0.0f) values[p] = sum[p] / count[p];
  }
}

class LayerBake {
 public:
  LayerBake(const LayerInput& input, const LayerRecipe& recipe) : in_(input), recipe_(recipe) {}

  BakedLayer bake(std::vector<std::filesystem::path>& dependencies) {
    cover();
    direct(dependencies);
    mask();
    weighConfidence();
    bias();
    measure();
    return std::move(out_);
  }

 private:
  size_t points() const { return in_.surface.point_positions.size(); }

  [[noreturn]] void fail(const std::string& wrong, const std::string& remedy) const {
    throw Error(Exit::kBadData, in_.recipe_file, "layer \"" + recipe_.name + "\": " + wrong, remedy);
  }

  void requireNames(const std::vector<std::string>& wanted, const std::set<std::string>& known,
                    const char* kind) const {
    for (const std::string& name : wanted)
      if (!known.count(name))
        fail(std::string("there is no ") + kind + " \"" + name + "\"",
             "the file has: " + joinNames({known.begin(), known.end()}));
  }

  void cover() {
    std::set<std::string> meshes, materials;
    const auto materialOf = [&](const Part& part) {
      return part.material < in_.scene.materials.size() ? in_.scene.materials[part.material].name
                                                        : std::string();
    };
    for (const Part& part : in_.scene.parts) {
      meshes.insert(part.mesh);
      materials.insert(materialOf(part));
    }
    requireNames(recipe_.meshes, meshes, "mesh");
    requireNames(recipe_.materials, materials, "material");
    const auto has = [](const std::vector<std::string>& list, const std::string& name) {
      return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
    };
    out_.covered.assign(in_.surface.triangles.size(), false);
    covered_part_.assign(in_.surface.parts.size(), false);
    covered_point_.assign(points(), false);
    for (size_t i = 0; i < in_.surface.parts.size(); ++i) {
      const SurfacePart& span = in_.surface.parts[i];
      const Part& part = in_.scene.parts[span.source_part];
      if (!has(recipe_.meshes, part.mesh) || !has(recipe_.materials, materialOf(part))) continue;
      covered_part_[i] = true;
      out_.parts.push_back(static_cast<uint32_t>(i));
      std::fill(out_.covered.begin() + span.triangle_begin, out_.covered.begin() + span.triangle_end, true);
      for (uint32_t v = span.vertex_begin; v < span.vertex_end; ++v)
        covered_point_[in_.surface.vertex_point[v]] = true;
    }
  }

  // A value of an attribute for every vertex of the covered parts; those that lack it get `otherwise`.
  std::vector<glm::vec4> attribute(const std::string& name, uint32_t least_components,
                                   glm::vec4 otherwise) const {
    std::vector<glm::vec4> values(in_.surface.positions.size(), otherwise);
    bool found = false;
    std::set<std::string> known;
    for (size_t i = 0; i < in_.surface.parts.size(); ++i) {
      const SurfacePart& span = in_.surface.parts[i];
      for (const Attribute& a :
           in_.scene.primitives[in_.scene.parts[span.source_part].primitive].attributes) {
        known.insert(a.name);
        if (!covered_part_[i] || a.name != name) continue;
        if (a.components < least_components)
          fail("attribute " + name + " has " + std::to_string(a.components) + " components",
               "choose one with at least " + std::to_string(least_components));
        found = true;
        for (uint32_t v = span.vertex_begin; v < span.vertex_end; ++v)
          for (uint32_t c = 0; c < std::min(4u, a.components); ++c)
            values[v][static_cast<int>(c)] =
                a.values[size_t{in_.source_vertex[v] - span.vertex_begin} * a.components + c];
      }
    }
    if (!found)
      fail("its meshes have no vertex attribute \"" + name + "\"",
           "the file has: " + joinNames({known.begin(), known.end()}));
    return values;
  }

  // Over a point's vertices in the covered parts; 0 where it has none.
  std::vector<float> pointMean(const std::vector<float>& vertex_values) const {
    std::vector<float> mean(points(), 0.0f), count(points(), 0.0f);
    for (size_t i = 0; i < in_.surface.parts.size(); ++i) {
      const SurfacePart& span = in_.surface.parts[i];
      for (uint32_t v = span.vertex_begin; covered_part_[i] && v < span.vertex_end; ++v) {
        mean[in_.surface.vertex_point[v]] += vertex_values[v];
        count[in_.surface.vertex_point[v]] += 1.0f;
      }
    }
    for (size_t p = 0; p < points(); ++p) mean[p] /= std::max(count[p], 1.0f);
    return mean;
  }

  void direct(std::vector<std::filesystem::path>& dependencies) {
    DirectionField field =
        std::visit([&](const auto& source) { return directions(source, dependencies); }, recipe_.direction);
    out_.field.direction = std::move(field.direction);
    out_.field.confidence = std::move(field.confidence);
  }

  using Files = std::vector<std::filesystem::path>;

  DirectionField directions(const DirectionAxis& source, Files&) {
    out_.axis = glm::normalize(glm::dvec3(source.axis[0], source.axis[1], source.axis[2]));
    return directionsFromAxis(in_.surface, *out_.axis);
  }

  DirectionField directions(const DirectionAnimation&, Files&) const {
    return directionsFromTensors(in_.surface, out_.covered, in_.squeeze.tensor);
  }

  DirectionField directions(const DirectionAttribute& source, Files&) const {
    const std::vector<glm::vec4> values = attribute(source.name, 3, glm::vec4(0.0f));
    std::vector<glm::vec3> vectors(values.size());
    for (const SurfacePart& span : in_.surface.parts)
      for (uint32_t v = span.vertex_begin; v < span.vertex_end; ++v)
        vectors[v] = glm::vec3(glm::dmat3(span.rest) * glm::dvec3(values[v]));
    return directionsFromTensors(in_.surface, out_.covered, tensorsOfVectors(in_.surface, vectors));
  }

  DirectionField directions(const DirectionTexture& source, Files& files) const {
    return directionsFromImage(source.texture, ImageKind::kFlow, files);
  }

  DirectionField directions(const DirectionMap&, Files& files) const {
    if (const auto* height = std::get_if<MapHeight>(&recipe_.compress))
      return directionsFromImage(height->texture, ImageKind::kHeight, files);
    if (const auto* normal = std::get_if<MapNormal>(&recipe_.compress))
      return directionsFromImage(normal->texture, ImageKind::kSlopes, files, normal->green);
    fail("its direction is that of its map, but \"compress\" names no image",
         "give \"compress\" a \"normal\" or \"height\", or choose another direction");
  }

  void requireUvs(const std::string& what) const {
    bool has_uvs = false;
    for (size_t i = 0; i < covered_part_.size(); ++i)
      has_uvs |= covered_part_[i] && in_.surface.parts[i].has_uvs;
    if (!has_uvs) fail(what + ", but its meshes have no UVs", "unwrap them, or use a vertex attribute");
  }

  DirectionField directionsFromImage(const std::filesystem::path& file, ImageKind kind, Files& files,
                                     Green green = Green::kOpenGl) const {
    requireUvs("its direction is read from an image");
    files.push_back(file);
    const auto given = in_.images.find(file);
    const Image image = kind == ImageKind::kSlopes   ? readNormals(file, green)
                        : kind == ImageKind::kHeight ? readHeights(file)
                        : given == in_.images.end()  ? readImage(file)
                                                     : toFloats(*given->second);
    if (image.channels < leastChannels(kind))
      throw Error(Exit::kBadData, file.string(), "it has " + std::to_string(image.channels) + " channels",
                  "use an image with " + std::to_string(leastChannels(kind)) +
                      " for the direction of layer \"" + recipe_.name + "\"");
    return directionsFromTensors(in_.surface, out_.covered,
                                 tensorsOfImage(in_.surface, out_.covered, image, kind));
  }

  DirectionField directions(const DirectionGuides& source, Files&) const {
    std::vector<std::array<glm::dvec3, 2>> segments;
    for (const auto& curve : source.curves)
      for (size_t i = 0; i + 1 < curve.size(); ++i)
        segments.push_back({glm::dvec3(curve[i][0], curve[i][1], curve[i][2]),
                            glm::dvec3(curve[i + 1][0], curve[i + 1][1], curve[i + 1][2])});
    if (!source.lines.empty()) addLines(source.lines, segments);
    try {
      return directionsFromGuides(in_.surface, out_.covered, segments);
    } catch (const std::runtime_error& error) {
      fail(error.what(), "draw them on the surface, in the scene root's space at rest");
    }
  }

  void addLines(const std::string& name, std::vector<std::array<glm::dvec3, 2>>& segments) const {
    const std::vector<glm::dmat4> world = worldMatrices(in_.scene.rig.nodes);
    std::set<std::string> known;
    for (const Lines& lines : in_.scene.lines) {
      const std::string& node = in_.scene.rig.nodes[lines.node].name;
      known.insert({lines.mesh, node});
      if (lines.mesh != name && node != name) continue;
      for (size_t i = 0; i + 1 < lines.points.size(); i += 2)
        segments.push_back({glm::dvec3(world[lines.node] * glm::dvec4(lines.points[i], 1.0)),
                            glm::dvec3(world[lines.node] * glm::dvec4(lines.points[i + 1], 1.0))});
    }
    requireNames({name}, known, "mesh or node of lines");
  }

  void mask() {
    std::vector<float>& strength = out_.field.strength;
    if (const auto* texture = std::get_if<MaskTexture>(&recipe_.mask)) {
      const ByteImage& image = in_.masks.at(texture->texture);
      checkMask(texture->texture, image, texture->channel, recipe_.name);
      std::vector<float> values;
      for (const glm::vec2& uv : in_.surface.uvs) values.push_back(sampleAt(image, uv, texture->channel));
      strength = pointMean(values);
    } else if (const auto* named = std::get_if<MaskAttribute>(&recipe_.mask)) {
      const std::vector<glm::vec4> values = attribute(named->name, named->channel + 1, glm::vec4(0.0f));
      std::vector<float> channel;
      for (const glm::vec4& value : values)
        channel.push_back(std::clamp(value[static_cast<int>(named->channel)], 0.0f, 1.0f));
      strength = pointMean(channel);
    } else if (std::holds_alternative<MaskNone>(recipe_.mask) || !in_.squeeze.any) {
      strength.assign(points(), 1.0f);
    } else {
      strength = squeezeMask();
    }
    bool empty = true, constant = true;
    float first = -1.0f;
    for (size_t p = 0; p < points(); ++p) {
      if (covered_point_[p] && first < 0.0f) first = strength[p];
      constant &= !covered_point_[p] || std::abs(strength[p] - first) < 0.5f / 255.0f;
      if (!covered_point_[p]) strength[p] = 0.0f;
      if (out_.field.direction[p] == glm::vec3(0.0f)) strength[p] = 0.0f;
      empty &= strength[p] < 1.0f / 255.0f;
    }
    const bool named = std::holds_alternative<MaskTexture>(recipe_.mask) ||
                       std::holds_alternative<MaskAttribute>(recipe_.mask);
    if (empty && named)
      fail("its mask is empty (black everywhere on its meshes)", "paint the mask or choose another channel");
    if (constant && std::holds_alternative<MaskAttribute>(recipe_.mask))
      fail("its mask is constant (one value everywhere on its meshes)",
           "choose another channel, or say \"mask\": \"none\" for the whole surface");
  }

  std::vector<float> squeezeMask() const {
    std::vector<float> mask = pointPeaks(in_.surface, in_.squeeze);
    for (float& s : mask) {
      const float x = std::clamp((s - kFadeBegin) / (kFadeEnd - kFadeBegin), 0.0f, 1.0f);
      s = x * x * (3.0f - 2.0f * x);
    }
    blur(in_.surface, kMaskBlurs, mask);
    return mask;
  }

  void weighConfidence() {
    double all = 0.0, unsure = 0.0;
    for (size_t t = 0; t < in_.surface.triangles.size(); ++t) {
      if (!out_.covered[t]) continue;
      const glm::uvec3 p = in_.surface.trianglePoints(t);
      const glm::vec3 a = in_.surface.point_positions[p.x];
      const double area =
          glm::length(glm::cross(in_.surface.point_positions[p.y] - a, in_.surface.point_positions[p.z] - a));
      for (int c = 0; c < 3; ++c) {
        all += area * out_.field.strength[p[c]];
        if (out_.field.confidence[p[c]] < kUnsure) unsure += area * out_.field.strength[p[c]];
      }
    }
    out_.unsure = all > 0.0 ? unsure / all : 0.0;
  }

  void bias() {
    if (!recipe_.bias) return;
    const auto neutral = static_cast<float>(recipe_.bias->neutral);
    std::vector<float> values = biasChannel(*recipe_.bias, neutral);
    for (float& c : values)
      c = std::abs(c - neutral) <= 1.0f / 255.0f ? 0.0f : std::clamp(2.0f * (c - neutral), -1.0f, 1.0f);
    out_.bias = pointMean(values);
  }

  // Of every vertex of the covered parts; `neutral` where there is nothing to be read.
  std::vector<float> biasChannel(const Bias& bias, float neutral) const {
    std::vector<float> values(in_.surface.positions.size(), neutral);
    if (bias.texture.empty()) {
      const std::vector<glm::vec4> all = attribute(bias.attribute, bias.channel + 1, glm::vec4(neutral));
      for (size_t v = 0; v < values.size(); ++v) values[v] = all[v][static_cast<int>(bias.channel)];
      return values;
    }
    const ByteImage& image = in_.masks.at(bias.texture);
    if (bias.channel >= image.channels)
      throw Error(Exit::kBadData, bias.texture.string(),
                  "the bias of layer \"" + recipe_.name + "\" is channel " +
                      std::string(1, "rgba"[bias.channel]) + ", and the image has " +
                      std::to_string(image.channels),
                  "choose another channel");
    requireUvs("its bias is read from an image");
    for (size_t i = 0; i < in_.surface.parts.size(); ++i) {
      const SurfacePart& span = in_.surface.parts[i];
      if (!covered_part_[i] || !span.has_uvs) continue;
      for (uint32_t v = span.vertex_begin; v < span.vertex_end; ++v)
        values[v] = sampleAt(image, in_.surface.uvs[v], bias.channel);
    }
    return values;
  }

  void measure() {
    if (recipe_.measure == Measure::kNone) return;
    const std::span<const Float3> normals = asFloat3(in_.surface.point_normals);
    const std::vector<PackedDirection> packed =
        packDirections(normals, asFloat3(out_.field.direction), out_.field.confidence);
    const auto bytes = std::as_bytes(std::span(packed));
    out_.directions.assign(bytes.begin(), bytes.end());
    out_.coefficients.resize(coefficientCount(recipe_.measure) * in_.surface.triangles.size());
    for (uint32_t part : out_.parts)
      makeCoefficients(restView(in_.surface), recipe_.measure, unpackDirections(normals, packed),
                       in_.surface.parts[part].triangle_begin, in_.surface.parts[part].triangle_end,
                       out_.coefficients);
  }

  const LayerInput& in_;
  const LayerRecipe& recipe_;
  BakedLayer out_;
  std::vector<bool> covered_part_;
  std::vector<bool> covered_point_;
};

}  // namespace

BakedLayer bakeLayer(const LayerInput& input, const LayerRecipe& recipe,
                     std::vector<std::filesystem::path>& dependencies) {
  return LayerBake(input, recipe).bake(dependencies);
}

std::string layerKey(const LayerInput& input, const LayerRecipe& recipe) {
  Recipe alone;
  LayerRecipe& layer = alone.layers.emplace_back();
  layer.name = recipe.name;
  layer.meshes = recipe.meshes;
  layer.materials = recipe.materials;
  layer.direction = recipe.direction;
  layer.measure = recipe.measure;
  layer.mask = recipe.mask;
  layer.bias = recipe.bias;
  std::string key = recipeText(alone, "/key");
  const auto add = [&](const ByteImage& image) {
    key += contentKey(std::as_bytes(std::span(image.pixels))) + ' ' + std::to_string(image.width) + ' ' +
           std::to_string(image.channels) + '\n';
  };
  if (const auto* mask = std::get_if<MaskTexture>(&layer.mask)) add(input.masks.at(mask->texture));
  if (layer.bias && !layer.bias->texture.empty()) add(input.masks.at(layer.bias->texture));
  if (std::holds_alternative<DirectionMap>(layer.direction)) return {};
  if (const auto* flow = std::get_if<DirectionTexture>(&layer.direction)) {
    const auto given = input.images.find(flow->texture);
    if (given == input.images.end()) return {};
    add(*given->second);
  }
  return key;
}

std::vector<float> pointPeaks(const Surface& surface, const Squeeze& squeeze) {
  std::vector<float> peaks(surface.point_positions.size(), 0.0f);
  for (size_t t = 0; t < squeeze.peak.size(); ++t) {
    const glm::uvec3 p = surface.trianglePoints(t);
    for (int c = 0; c < 3; ++c) peaks[p[c]] = std::max(peaks[p[c]], squeeze.peak[t]);
  }
  return peaks;
}

}  // namespace furrow::pipeline
