#include "pipeline/cook/packing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numeric>

#include "pipeline/bake/rest_view.h"
#include "pipeline/bake/tangents.h"
#include "pipeline/release.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

constexpr std::string_view kColorAttribute = "COLOR_0";

class Packer {
 public:
  Packer(SourceScene& scene, Weld& weld, const Recipe& recipe, const RestPose& rest, GeometryCodec codec)
      : scene_(scene), weld_(weld), recipe_(recipe), rest_(rest), codec_(codec) {}

  Packing pack(const std::vector<glm::vec3>& before) {
    const bool bind = std::holds_alternative<RestBind>(recipe_.rest);
    const std::vector<glm::vec3> elsewhere = bind ? std::vector<glm::vec3>() : sourcePositions(scene_);
    packParts();
    makeSurface(before, bind ? before : elsewhere);
    return std::move(out_);
  }

 private:
  // Per point, the sum of its triangles' normals times twice their area, in root space, a mirrored part's
  // turned outwards; empty if no primitive lacks normals.
  std::vector<glm::dvec3> triangleNormals(std::span<const glm::dmat4> bind) const {
    std::vector<glm::dvec3> sums;
    const auto has_normals = [&](const Part& part) {
      return !scene_.primitives[part.primitive].normals.empty();
    };
    if (std::ranges::all_of(scene_.parts, has_normals)) return sums;
    sums.assign(weld_.points, glm::dvec3(0.0));
    uint32_t first_vertex = 0;
    for (size_t i = 0; i < scene_.parts.size(); ++i) {
      const Primitive& primitive = scene_.primitives[scene_.parts[i].primitive];
      const glm::dmat3 linear(bind[i]);
      const double hand = glm::determinant(linear) < 0.0 ? -1.0 : 1.0;
      for (const glm::uvec3& t : trianglesOf(primitive)) {
        const glm::dvec3 a = primitive.positions[t.x];
        const glm::dvec3 n = glm::cross(linear * (glm::dvec3(primitive.positions[t.y]) - a),
                                        linear * (glm::dvec3(primitive.positions[t.z]) - a));
        for (int c = 0; c < 3; ++c) sums[weld_.vertex_point[first_vertex + t[c]]] += hand * n;
      }
      first_vertex += static_cast<uint32_t>(primitive.positions.size());
    }
    return sums;
  }

  // Unit normals of a part's vertices that has none in the file.
  std::vector<glm::vec3> smoothNormals(const Part& part, uint32_t first_vertex, const glm::dmat4& bind,
                                       std::span<const glm::dvec3> smooth) const {
    std::vector<glm::vec3> normals(scene_.primitives[part.primitive].positions.size());
    for (size_t v = 0; v < normals.size(); ++v)
      normals[v] = unit(smooth[weld_.vertex_point[first_vertex + v]] * glm::dmat3(bind), {0, 1, 0});
    return normals;
  }

  // Vertices of one point get one position, on the coarsest lattice of their parts, which the others contain:
  // no crack opens between materials, and none where an exporter has jittered a seam. Left alone are points
  // of several spaces, and primitives that several nodes show.
  void closeCracks(std::span<const glm::dmat4> bind, std::span<const float> steps) {
    struct Joint {
      uint32_t part = kNoIndex;
      glm::vec3 position{0.0f};
      float step = 0.0f;
      bool open = false;
    };
    std::vector<Joint> joints(weld_.points);
    std::vector<uint32_t> uses(scene_.primitives.size(), 0);
    for (const Part& part : scene_.parts) ++uses[part.primitive];
    const auto eachVertex = [&](const auto& visit) {
      uint32_t vertex = 0;
      for (uint32_t p = 0; p < scene_.parts.size(); ++p) {
        Primitive& primitive = scene_.primitives[scene_.parts[p].primitive];
        for (glm::vec3& position : primitive.positions)
          visit(p, position, joints[weld_.vertex_point[vertex++]]);
      }
    };
    eachVertex([&](uint32_t p, const glm::vec3& position, Joint& joint) {
      if (joint.part == kNoIndex) joint = {p, position, steps[p], false};
      if (bind[p] != bind[joint.part]) return;
      joint.open = joint.open || p != joint.part || position != joint.position;
      joint.step = std::max(joint.step, steps[p]);
    });
    eachVertex([&](uint32_t p, glm::vec3& position, const Joint& joint) {
      if (joint.open && joint.step > 0.0f && uses[scene_.parts[p].primitive] == 1 &&
          bind[p] == bind[joint.part])
        position = glm::round(joint.position / joint.step) * joint.step;
    });
  }

  // Packs every part, then replaces the scene's positions by what the runtime will decode, so that all that
  // follows is baked from that.
  void packParts() {
    uint32_t first_vertex = 0;
    const std::vector<glm::dmat4> bind = bindMatrices(scene_);
    std::vector<float> steps;
    for (const Part& part : scene_.parts) {
      const Primitive& primitive = scene_.primitives[part.primitive];
      steps.push_back(positionStep(primitive.positions, primitive.indices));
    }
    closeCracks(bind, steps);
    const std::vector<glm::dvec3> smooth = triangleNormals(bind);
    for (Primitive& primitive : scene_.primitives)
      for (glm::vec3& n : primitive.normals) n = unit(n, {0, 1, 0});
    std::vector<std::vector<glm::vec3>> decoded(scene_.primitives.size());
    for (const Part& part : scene_.parts) {
      const Primitive& primitive = scene_.primitives[part.primitive];
      const size_t number = out_.parts.size();
      const auto quantized = [&] {
        std::vector<glm::vec3> made_normals;
        if (primitive.normals.empty()) made_normals = smoothNormals(part, first_vertex, bind[number], smooth);
        const std::span<const glm::vec3> normals =
            primitive.normals.empty() ? made_normals : primitive.normals;
        std::vector<glm::vec4> made_frames;
        if (primitive.tangents.empty())
          made_frames = tangents(primitive.positions, normals, primitive.uvs, trianglesOf(primitive));
        const std::span<const glm::vec4> frames =
            primitive.tangents.empty() ? made_frames : primitive.tangents;
        return quantizePart(primitive, normals, frames, part.skinned ? part.palette_count : 1, steps[number]);
      };
      PackedPart packed = packGeometry(quantized, primitive.indices, codec_, geometry_.emplace_back());
      packed.mesh = part.mesh;
      if (part.material < scene_.materials.size()) {
        packed.material = scene_.materials[part.material].name;
        packed.base_color = scene_.materials[part.material].base_color;
        packed.roughness = scene_.materials[part.material].roughness;
      }
      packColors(primitive, geometry_.back().source);
      packed.palette_begin = part.palette_begin;
      packed.rest = bind[number];
      packed.has_normals = !primitive.normals.empty();
      packed.has_uvs = !primitive.uvs.empty();
      out_.influences = std::max(out_.influences, influencesOf(packed));
      first_vertex += packed.vertices;
      if (packed.draco.empty() && codec_ == GeometryCodec::kDraco)
        out_.warnings.push_back("mesh \"" + part.mesh + "\" could not be Draco-encoded and is stored raw");
      out_.parts.push_back(std::move(packed));
      std::vector<glm::vec3>& positions = decoded[part.primitive];
      positions.resize(primitive.positions.size());
      for (size_t v = 0; v < positions.size(); ++v) {
        const Float3 p = geometry_.back().positions[v];
        positions[geometry_.back().source[v]] = {p.x, p.y, p.z};
      }
    }
    for (size_t i = 0; i < decoded.size(); ++i) {
      Primitive& primitive = scene_.primitives[i];
      if (!decoded[i].empty()) primitive.positions = std::move(decoded[i]);
      // The surface has them from here on.
      release(primitive.normals, primitive.tangents, primitive.uvs, primitive.indices);
    }
  }

  // Colours follow the vertices in `source`.
  void packColors(const Primitive& primitive, std::span<const uint32_t> source) {
    const auto found = std::ranges::find(primitive.attributes, kColorAttribute, &Attribute::name);
    if (found != primitive.attributes.end() && colorsAreColors(recipe_)) {
      out_.colors.resize(packed_vertices_, glm::u8vec4(255));
      for (uint32_t v : source) {
        const float* c = &found->values[size_t{v} * found->components];
        glm::u8vec4& packed = out_.colors.emplace_back(255);
        for (int k = 0; k < 3; ++k)
          packed[k] = static_cast<uint8_t>(std::lround(255.0f * std::sqrt(std::clamp(c[k], 0.0f, 1.0f))));
      }
    } else if (!out_.colors.empty()) {
      out_.colors.resize(out_.colors.size() + source.size(), glm::u8vec4(255));
    }
    packed_vertices_ += source.size();
  }

  // `source_rest` and `source_bind`: where the source's vertices are at rest and in the bind pose.
  void makeSurface(const std::vector<glm::vec3>& source_rest, const std::vector<glm::vec3>& source_bind) {
    // At rest in the bind pose, what the loader makes of the part's matrix as it is stored.
    const bool bind = std::holds_alternative<RestBind>(recipe_.rest);
    const std::vector<glm::vec3> rest = bind ? std::vector<glm::vec3>() : rest_.positions(scene_);
    std::vector<glm::vec3> elsewhere;  // the bind pose's positions, if the surface has others

    std::vector<uint32_t> source_point;
    for (uint32_t i = 0; i < scene_.parts.size(); ++i) {
      const PartGeometry& geometry = geometry_[i];
      SurfacePart span;
      span.vertex_begin = static_cast<uint32_t>(out_.surface.positions.size());
      span.triangle_begin = static_cast<uint32_t>(out_.surface.triangles.size());
      span.source_part = i;
      span.rest = out_.parts[i].rest;
      span.has_uvs = out_.parts[i].has_uvs;
      const glm::dmat3 linear(span.rest);
      const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                glm::cross(linear[0], linear[1]));
      const double hand = glm::determinant(linear) < 0.0 ? -1.0 : 1.0;
      Affine to_root;
      std::ranges::copy(affineRows(span.rest), to_root.m);
      for (size_t v = 0; v < geometry.positions.size(); ++v) {
        const uint32_t source = span.vertex_begin + geometry.source[v];
        const Float3 n = geometry.normals[v];
        const Float4 t = geometry.tangents[v];
        const glm::vec3 normal = unit(hand * (cofactor * glm::dvec3(n.x, n.y, n.z)), {0, 1, 0});
        const glm::dvec3 along = linear * glm::dvec3(t.x, t.y, t.z);
        const glm::vec3 tangent =
            unit(along - glm::dot(along, glm::dvec3(normal)) * glm::dvec3(normal), {1, 0, 0});
        out_.source_vertex.push_back(source);
        source_point.push_back(weld_.vertex_point[source]);
        const Float3 p = transformed(to_root, geometry.positions[v]);
        const glm::vec3 placed(p.x, p.y, p.z);
        if (!bind) elsewhere.push_back(placed);
        out_.surface.positions.push_back(bind ? placed : rest[source]);
        out_.position_error = std::max(
            out_.position_error, double{glm::distance(out_.surface.positions.back(), source_rest[source])});
        out_.surface.normals.push_back(normal);
        out_.surface.tangents.push_back(glm::vec4(tangent, static_cast<float>(hand) * t.w));
        out_.surface.uvs.push_back(glm::vec2(geometry.uvs[v].x, geometry.uvs[v].y));
      }
      for (size_t f = 0; f + 2 < geometry.indices.size(); f += 3)
        out_.surface.triangles.push_back(
            glm::uvec3(geometry.indices[f], geometry.indices[f + 1], geometry.indices[f + 2]) +
            span.vertex_begin);
      span.vertex_end = static_cast<uint32_t>(out_.surface.positions.size());
      span.triangle_end = static_cast<uint32_t>(out_.surface.triangles.size());
      out_.surface.parts.push_back(span);
    }
    release(geometry_);
    numberPoints(source_point);
    measurePlaces(source_bind, bind ? out_.surface.positions : elsewhere);
    release(weld_.vertex_point, weld_.vertex_place);
    pointGeometry();
  }

  static glm::vec3 unit(glm::dvec3 v, glm::vec3 otherwise) {
    const double length = glm::length(v);
    return length > 0.0 && std::isfinite(length) ? glm::vec3(v / length) : otherwise;
  }

  // Points in the order in which the asset's vertices first meet their places, the points of one place next
  // to each other.
  void numberPoints(const std::vector<uint32_t>& source_point) {
    std::vector<uint32_t> place_of_point(weld_.points), first_of_place(weld_.places + 1, 0);
    for (size_t v = 0; v < weld_.vertex_point.size(); ++v)
      place_of_point[weld_.vertex_point[v]] = weld_.vertex_place[v];
    for (uint32_t place : place_of_point) ++first_of_place[place + 1];
    std::partial_sum(first_of_place.begin(), first_of_place.end(), first_of_place.begin());
    std::vector<uint32_t> points_by_place(weld_.points), free = first_of_place;
    for (uint32_t p = 0; p < weld_.points; ++p) points_by_place[free[place_of_point[p]]++] = p;
    std::vector<uint32_t> number(weld_.points, kNoIndex), first_point(weld_.places);
    uint32_t next = 0;
    for (uint32_t point : source_point) {
      if (number[point] == kNoIndex) {
        const uint32_t place = place_of_point[point];
        const uint32_t begin = first_of_place[place], end = first_of_place[place + 1];
        first_point[place] = next;
        for (uint32_t i = begin; i < end; ++i) number[points_by_place[i]] = next++;
      }
      out_.surface.vertex_point.push_back(number[point]);
    }
    for (uint32_t place : weld_.slot_place)
      out_.place_points.push_back({first_point[place], first_of_place[place + 1] - first_of_place[place]});
  }

  void measurePlaces(const std::vector<glm::vec3>& source, const std::vector<glm::vec3>& placed) {
    std::vector<uint32_t> point_vertex(weld_.points, kNoIndex), place_vertex(weld_.places);
    for (uint32_t v = 0; v < placed.size(); ++v) {
      uint32_t& vertex = point_vertex[out_.surface.vertex_point[v]];
      vertex = std::min(vertex, v);
    }
    for (size_t slot = 0; slot < out_.place_points.size(); ++slot)
      place_vertex[weld_.slot_place[slot]] = point_vertex[out_.place_points[slot].first];
    double error = 0.0;
    for (const uint32_t v : out_.source_vertex)
      error = std::max(error, glm::distance(glm::dvec3(source[v]),
                                            glm::dvec3(placed[place_vertex[weld_.vertex_place[v]]])));
    out_.place_error = std::nextafter(static_cast<float>(error), INFINITY);
  }

  void pointGeometry() {
    out_.surface.point_positions.assign(weld_.points, glm::vec3(0.0f));
    std::vector<bool> seen(weld_.points);
    for (size_t v = 0; v < out_.surface.positions.size(); ++v) {
      const uint32_t p = out_.surface.vertex_point[v];
      if (!seen[p])
        out_.surface.point_positions[p] = out_.surface.positions[v];  // the vertex that stands for the point
      seen[p] = true;
    }
    for (const Float3& n : pointNormals(restView(out_.surface)))
      out_.surface.point_normals.push_back({n.x, n.y, n.z});
  }

  SourceScene& scene_;
  Weld& weld_;
  const Recipe& recipe_;
  const RestPose& rest_;
  const GeometryCodec codec_;
  std::vector<PartGeometry> geometry_;
  size_t packed_vertices_ = 0;
  Packing out_;
};

}  // namespace

std::vector<glm::vec3> RestPose::positions(const SourceScene& scene) const {
  if (std::holds_alternative<RestBind>(rest)) return sourcePositions(scene);
  std::vector<glm::vec3> out;
  for (const glm::dvec3& p : restPositions(scene, rest))
    out.push_back(glm::vec3(offsets.empty() ? p : p + offsets[out.size()]));
  requireInRange(scene, out);
  return out;
}

Packing packScene(SourceScene& scene, Weld& weld, const Recipe& recipe, const RestPose& rest,
                  const std::vector<glm::vec3>& before, GeometryCodec codec) {
  return Packer(scene, weld, recipe, rest, codec).pack(before);
}

bool colorsAreColors(const Recipe& recipe) {
  return std::ranges::none_of(recipe.layers, [](const LayerRecipe& layer) {
    const auto* mask = std::get_if<MaskAttribute>(&layer.mask);
    const auto* direction = std::get_if<DirectionAttribute>(&layer.direction);
    return (layer.bias && layer.bias->attribute == kColorAttribute) ||
           (mask && mask->name == kColorAttribute) || (direction && direction->name == kColorAttribute);
  });
}

std::span<const glm::uvec3> trianglesOf(const Primitive& primitive) {
  return {reinterpret_cast<const glm::uvec3*>(primitive.indices.data()), primitive.indices.size() / 3};
}

}  // namespace furrow::pipeline
