#include "pipeline/cook/cook.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numeric>
#include <set>
#include <span>

#include "pipeline/bake/response_fit.h"
#include "pipeline/bake/rest_view.h"
#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/tangents.h"
#include "pipeline/bake/weld.h"
#include "pipeline/cook/base_maps.h"
#include "pipeline/cook/layer_bake.h"
#include "pipeline/cook/map_bake.h"
#include "pipeline/cook/writer.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/pack/geometry.h"
#include "pipeline/parallel.h"
#include "pipeline/recipe/arkit.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

constexpr std::string_view kColorAttribute = "COLOR_0";

// Gives their memory back; a vector keeps it when it is merely cleared.
template <typename... T>
void release(T&... values) {
  ((values = T()), ...);
}

class Cook {
 public:
  Cook(SourceScene scene, const Recipe& recipe, const CookOptions& options)
      : scene_(std::move(scene)),
        recipe_(recipe),
        options_(options),
        recipe_file_(recipe.file.empty() ? scene_.file.string() : recipe.file.string()) {}

  Cooked run() {
    check();
    if (const auto* rest = std::get_if<RestFile>(&recipe_.rest)) {
      const SourceScene file = import(rest->file);
      rest_offsets_ = restOffsets(scene_, file);
      dependencies_ = file.dependencies;
    }
    stage("reading the model's maps");
    bakeOwnMaps();
    stage("welding");
    weldVertices();
    std::vector<glm::vec3> source_rest = restFloats();
    inspectTriangles(source_rest);
    stage("packing geometry");
    packParts();
    makeSurface(source_rest);
    release(source_rest);
    stage("measuring the animation");
    Rings rings = makeRings(restView(surface_));
    Squeeze squeeze;
    if (needsSqueeze()) {
      squeeze = measureSqueeze(scene_, surface_, source_vertex_);
      if (!squeeze.any())
        warn(
            "no clip and no morph target squeezes it: wrinkles will only come from bias, region weights and "
            "drivers");
    }
    stage("baking layers");
    const MaskImages masks = maskImages();
    const LayerInput input{scene_, surface_, source_vertex_, squeeze, masks, options_.images, recipe_file_};
    std::vector<BakedLayer> layers(recipe_.layers.size());
    std::vector<std::vector<std::filesystem::path>> images(layers.size());
    parallelFor(static_cast<uint32_t>(layers.size()), options_.threads,
                [&](uint32_t l) { layers[l] = bakeLayer(input, recipe_.layers[l], images[l]); });
    for (const auto& files : images) dependencies_.insert(dependencies_.end(), files.begin(), files.end());
    resolveNames();
    fitResponses(rings, layers);
    reportConfidence(squeeze, layers);
    for (size_t l = 0; l < layers.size(); ++l) resolveMaps(input, layers[l], recipe_.layers[l]);
    stage("making maps");
    std::vector<BakedTextureSet> sets =
        bakeMaps(input, recipe_, layers, options_.threads, dependencies_, report_.warnings);
    for (uint32_t s = 0; s < sets.size(); ++s)
      for (uint32_t part : sets[s].parts) parts_[part].texture_set = s;

    stage("packing");
    Cooked cooked;
    cooked.bytes = writeAsset({scene_, surface_, weld_, recipe_, layers, sets, base_maps_.maps, parts_,
                               source_vertex_, colors_, place_points_, influences_, position_error_});
    report();
    release(rings, squeeze, layers, sets, surface_, parts_, weld_, source_vertex_, scene_.primitives);
    stage("loading it again");
    Asset loaded;
    if (const Status status = loaded.load(cooked.bytes); !status.ok())
      throw Error(Exit::kBadData, scene_.file.string(),
                  std::string("the asset made of it does not load (") + status.message + ")",
                  "report this as a fault of furrow");
    endStage();
    const auto tellTexture = [&](const std::string& set, const Texture& texture, bool own) {
      if (texture.slices > 0)
        report_.textures.push_back({set, texture.format, texture.width, texture.height, texture.slices,
                                    texture.data.size(), texture.rms_error, texture.largest_error, own});
    };
    for (const TextureSet& set : loaded.view().texture_sets)
      for (const Texture* texture : {&set.normals, &set.shading, &set.masks})
        tellTexture(std::string(set.name), *texture, false);
    for (size_t i = 0; i < base_maps_.maps.size(); ++i)
      for (const Texture* texture : {&loaded.view().base_maps[i].color, &loaded.view().base_maps[i].normal})
        tellTexture(base_maps_.maps[i].material, *texture, true);
    report_.bytes = cooked.bytes.size();
    report_.morph_error = double{loaded.view().morph_error};
    cooked.recipe = recipe_;
    cooked.report = std::move(report_);
    cooked.dependencies = scene_.dependencies;
    if (!recipe_.file.empty()) cooked.dependencies.push_back(recipe_.file);
    cooked.dependencies.insert(cooked.dependencies.end(), dependencies_.begin(), dependencies_.end());
    return cooked;
  }

 private:
  void bakeOwnMaps() {
    base_maps_ = bakeBaseMaps(scene_, recipe_.preview_size, options_.threads);
    for (std::string& warning : base_maps_.warnings) warn(std::move(warning));
    dependencies_.insert(dependencies_.end(), base_maps_.dependencies.begin(), base_maps_.dependencies.end());
    release(scene_.images);
  }

  void stage(const char* name) {
    endStage();
    report_.stages.push_back({name});
    options_.progress(name);
  }
  void endStage() {
    const auto now = std::chrono::steady_clock::now();
    if (!report_.stages.empty())
      report_.stages.back().seconds = std::chrono::duration<double>(now - stage_begin_).count();
    stage_begin_ = now;
  }

  void warn(std::string text) { report_.warnings.push_back(std::move(text)); }

  void check() {
    report_.warnings = scene_.warnings;
    for (LayerRecipe& layer : recipe_.layers) resolveDrivers(layer);
    if (scene_.rig.palette.size() > kMaxPaletteEntries || scene_.rig.morphs.size() > 65535)
      throw Error(Exit::kBadData, scene_.file.string(), "it has more than 65536 joints or morph targets",
                  "split it into several files");
  }

  // Names the morph targets as the file does, and takes tables apart.
  void resolveDrivers(LayerRecipe& layer) {
    std::vector<std::string> names;
    for (const MorphTarget& target : scene_.rig.morphs)
      if (std::find(names.begin(), names.end(), target.name) == names.end()) names.push_back(target.name);
    std::vector<DriverRecipe> wanted = layer.drivers;
    for (const auto& [shape, gain] : driverTable(layer.driver_table)) wanted.push_back({shape, gain});
    layer.drivers.clear();
    for (const DriverRecipe& driver : wanted) {
      const std::vector<size_t> found = matchShape(names, driver.morph);
      if (found.empty() && layer.driver_table.empty())
        throw Error(Exit::kBadData, recipe_file_,
                    "layer \"" + layer.name + "\": there is no morph target \"" + driver.morph + "\"",
                    "the file has: " + joinNames(names));
      for (size_t i : found)
        layer.drivers.push_back({names[i], driver.gain / static_cast<double>(found.size()), driver.curve});
    }
    if (!layer.driver_table.empty() && layer.drivers.empty())
      warn("layer \"" + layer.name + "\": no morph target is one of " + layer.driver_table);
    layer.driver_table.clear();
  }

  void weldVertices() {
    std::optional<Weld> made = weld(scene_, recipe_.weld_tolerance, rest_offsets_);
    if (!made)
      throw Error(Exit::kBadData, recipe_file_,
                  "weld.tolerance: thousands of vertices lie within a few of it of each other",
                  "give a length well below that of the edges, or leave it out");
    weld_ = std::move(*made);
    recipe_.weld_tolerance = weld_.tolerance;
  }

  // Draco drops faces without area, so the source's are looked at.
  void inspectTriangles(const std::vector<glm::vec3>& source_rest) {
    std::vector<glm::uvec3> triangles;
    uint32_t first_vertex = 0;
    for (const Part& part : scene_.parts) {
      const Primitive& primitive = scene_.primitives[part.primitive];
      for (const glm::uvec3& t : trianglesOf(primitive)) triangles.push_back(t + first_vertex);
      first_vertex += static_cast<uint32_t>(primitive.positions.size());
    }
    report_.polygons = scene_.polygons;
    report_.topology = inspect(source_rest, weld_.vertex_point, triangles);
  }

  void tellTopology() {
    const auto tell = [&](uint32_t count, const char* what) {
      if (count > 0) warn(std::to_string(count) + what);
    };
    const Topology& topology = report_.topology;
    tell(topology.degenerate_triangles, " triangles have no area and are in no ring");
    tell(topology.duplicate_triangles, " triangles have the corners of another one");
    tell(topology.non_manifold_edges, " edges have more than two triangles");
    tell(topology.isolated_vertices, " vertices are in no triangle");
  }

  static std::span<const glm::uvec3> trianglesOf(const Primitive& primitive) {
    return {reinterpret_cast<const glm::uvec3*>(primitive.indices.data()), primitive.indices.size() / 3};
  }

  bool needsSqueeze() const {
    return std::any_of(recipe_.layers.begin(), recipe_.layers.end(), [](const LayerRecipe& layer) {
      return std::holds_alternative<DirectionAnimation>(layer.direction) ||
             std::holds_alternative<MaskAuto>(layer.mask) ||
             std::holds_alternative<MapSynthesized>(layer.compress) ||
             std::holds_alternative<MapSynthesized>(layer.stretch);
    });
  }

  MaskImages maskImages() {
    std::set<std::filesystem::path> named;
    for (const LayerRecipe& layer : recipe_.layers) {
      if (const auto* mask = std::get_if<MaskTexture>(&layer.mask)) named.insert(mask->texture);
      if (layer.bias && !layer.bias->texture.empty()) named.insert(layer.bias->texture);
    }
    dependencies_.insert(dependencies_.end(), named.begin(), named.end());
    std::erase_if(named, [&](const auto& file) { return options_.images.contains(file); });
    const std::vector<std::filesystem::path> files(named.begin(), named.end());
    MaskImages images = readMasks(files, options_.threads);
    for (const auto& [file, image] : options_.images) images.emplace(file, *image);
    return images;
  }

  // Root-space rest positions of all parts in source order.
  std::vector<glm::vec3> restFloats() const {
    std::vector<glm::vec3> out;
    for (const glm::dvec3& p : restPositions(scene_, recipe_.rest))
      out.push_back(glm::vec3(rest_offsets_.empty() ? p : p + rest_offsets_[out.size()]));
    requireInRange(scene_, out);
    return out;
  }

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

  // Unit normals of a part's vertices; `smooth` ones where the file has none.
  std::vector<glm::vec3> normalsOf(const Part& part, uint32_t first_vertex, const glm::dmat4& bind,
                                   std::span<const glm::dvec3> smooth) const {
    const Primitive& primitive = scene_.primitives[part.primitive];
    std::vector<glm::vec3> normals = primitive.normals;
    if (normals.empty())
      for (size_t v = 0; v < primitive.positions.size(); ++v)
        normals.push_back(unit(smooth[weld_.vertex_point[first_vertex + v]] * glm::dmat3(bind), {0, 1, 0}));
    for (glm::vec3& n : normals) n = unit(n, {0, 1, 0});
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
    std::vector<std::vector<glm::vec3>> decoded(scene_.primitives.size());
    for (const Part& part : scene_.parts) {
      const Primitive& primitive = scene_.primitives[part.primitive];
      const std::vector<glm::vec3> normals = normalsOf(part, first_vertex, bind[parts_.size()], smooth);
      const std::span<const glm::uvec3> triangles = trianglesOf(primitive);
      const std::vector<glm::vec4> frames =
          primitive.tangents.empty() ? tangents(primitive.positions, normals, primitive.uvs, triangles)
                                     : primitive.tangents;
      PackedPart packed = packGeometry(primitive, normals, frames, part.skinned ? part.palette_count : 1,
                                       steps[parts_.size()], options_.geometry, geometry_.emplace_back());
      packed.mesh = part.mesh;
      if (part.material < scene_.materials.size()) {
        packed.material = scene_.materials[part.material].name;
        packed.base_color = scene_.materials[part.material].base_color;
        packed.roughness = scene_.materials[part.material].roughness;
        if (!primitive.uvs.empty()) packed.base_maps = base_maps_.of_material[part.material];
      }
      packColors(primitive, geometry_.back().source);
      packed.palette_begin = part.palette_begin;
      packed.rest = bind[parts_.size()];
      packed.has_normals = !primitive.normals.empty();
      packed.has_uvs = !primitive.uvs.empty();
      influences_ = std::max(influences_, influencesOf(packed));
      first_vertex += packed.vertices;
      if (packed.draco.empty() && options_.geometry == GeometryCodec::kDraco)
        warn("mesh \"" + part.mesh + "\" could not be Draco-encoded and is stored raw");
      parts_.push_back(std::move(packed));
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
      release(primitive.normals, primitive.tangents, primitive.uvs);  // the surface has them from here on
    }
  }

  // COLOR_0 is a colour unless a layer reads its bias or mask from it. Colours follow the vertices in
  // `source`.
  void packColors(const Primitive& primitive, std::span<const uint32_t> source) {
    const auto found = std::ranges::find(primitive.attributes, kColorAttribute, &Attribute::name);
    if (found != primitive.attributes.end() && colorsAreColors()) {
      colors_.resize(packed_vertices_, glm::u8vec4(255));
      for (uint32_t v : source) {
        const float* c = &found->values[size_t{v} * found->components];
        glm::u8vec4& packed = colors_.emplace_back(255);
        for (int k = 0; k < 3; ++k)
          packed[k] = static_cast<uint8_t>(std::lround(255.0f * std::sqrt(std::clamp(c[k], 0.0f, 1.0f))));
      }
    } else if (!colors_.empty()) {
      colors_.resize(colors_.size() + source.size(), glm::u8vec4(255));
    }
    packed_vertices_ += source.size();
  }

  bool colorsAreColors() const {
    return std::ranges::none_of(recipe_.layers, [](const LayerRecipe& layer) {
      const auto* mask = std::get_if<MaskAttribute>(&layer.mask);
      const auto* direction = std::get_if<DirectionAttribute>(&layer.direction);
      return (layer.bias && layer.bias->attribute == kColorAttribute) ||
             (mask && mask->name == kColorAttribute) || (direction && direction->name == kColorAttribute);
    });
  }

  void makeSurface(const std::vector<glm::vec3>& source_rest) {
    // At rest in the bind pose, what the loader makes of the part's matrix as it is stored.
    const bool bind = std::holds_alternative<RestBind>(recipe_.rest);
    const std::vector<glm::vec3> rest = bind ? std::vector<glm::vec3>() : restFloats();

    std::vector<uint32_t> source_point;
    for (uint32_t i = 0; i < scene_.parts.size(); ++i) {
      const PartGeometry& geometry = geometry_[i];
      SurfacePart span;
      span.vertex_begin = static_cast<uint32_t>(surface_.positions.size());
      span.triangle_begin = static_cast<uint32_t>(surface_.triangles.size());
      span.source_part = i;
      span.rest = parts_[i].rest;
      span.has_uvs = parts_[i].has_uvs;
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
        source_vertex_.push_back(source);
        source_point.push_back(weld_.vertex_point[source]);
        const Float3 p = transformed(to_root, geometry.positions[v]);
        surface_.positions.push_back(bind ? glm::vec3(p.x, p.y, p.z) : rest[source]);
        position_error_ =
            std::max(position_error_, double{glm::distance(surface_.positions.back(), source_rest[source])});
        surface_.normals.push_back(normal);
        surface_.tangents.push_back(glm::vec4(tangent, static_cast<float>(hand) * t.w));
        surface_.uvs.push_back(glm::vec2(geometry.uvs[v].x, geometry.uvs[v].y));
      }
      for (size_t f = 0; f + 2 < geometry.indices.size(); f += 3)
        surface_.triangles.push_back(
            glm::uvec3(geometry.indices[f], geometry.indices[f + 1], geometry.indices[f + 2]) +
            span.vertex_begin);
      span.vertex_end = static_cast<uint32_t>(surface_.positions.size());
      span.triangle_end = static_cast<uint32_t>(surface_.triangles.size());
      surface_.parts.push_back(span);
    }
    release(geometry_);
    numberPoints(source_point);
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
      surface_.vertex_point.push_back(number[point]);
    }
    for (uint32_t place : weld_.slot_place)
      place_points_.push_back({first_point[place], first_of_place[place + 1] - first_of_place[place]});
  }

  void pointGeometry() {
    surface_.point_positions.assign(weld_.points, glm::vec3(0.0f));
    std::vector<bool> seen(weld_.points);
    for (size_t v = 0; v < surface_.positions.size(); ++v) {
      const uint32_t p = surface_.vertex_point[v];
      if (!seen[p])
        surface_.point_positions[p] = surface_.positions[v];  // the vertex that stands for the point
      seen[p] = true;
    }
    for (const Float3& n : pointNormals(restView(surface_)))
      surface_.point_normals.push_back({n.x, n.y, n.z});
  }

  // Names what a layer lies on where the recipe says "all" and every name can stand in a recipe.
  void resolveNames() {
    std::vector<std::string> meshes, materials;
    const auto add = [](std::vector<std::string>& names, const std::string& name) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    for (const Part& part : scene_.parts) {
      add(meshes, part.mesh);
      add(materials, part.material < scene_.materials.size() ? scene_.materials[part.material].name : "");
    }
    for (std::vector<std::string>* names : {&meshes, &materials})
      if (!std::all_of(names->begin(), names->end(), isRecipeText)) names->clear();
    for (LayerRecipe& layer : recipe_.layers) {
      if (layer.meshes.empty()) layer.meshes = meshes;
      if (layer.materials.empty()) layer.materials = materials;
    }
  }

  void fitResponses(const Rings& rings, const std::vector<BakedLayer>& layers) {
    std::vector<size_t> fitted;
    std::vector<MeasuredLayer> measured;
    for (size_t l = 0; l < layers.size(); ++l) {
      report_.layers.push_back({recipe_.layers[l].name, {}, {}});
      if (!recipe_.layers[l].fit) continue;
      fitted.push_back(l);
      measured.push_back({recipe_.layers[l].measure, layers[l].coefficients});
    }
    if (!fitted.empty()) {
      const auto alpha = largestAlpha(scene_, surface_, source_vertex_, rings, measured);
      for (size_t i = 0; i < fitted.size(); ++i)
        fitLayer(fitted[i], percentile95(surface_, layers[fitted[i]].covered,
                                         layers[fitted[i]].field.strength, alpha[i]));
    }
    for (size_t l = 0; l < layers.size(); ++l) report_.layers[l].response = recipe_.layers[l].response;
  }

  void reportConfidence(const Squeeze& squeeze, const std::vector<BakedLayer>& layers) {
    constexpr double kMuch = 0.5;
    for (size_t l = 0; l < layers.size(); ++l) {
      const LayerRecipe& layer = recipe_.layers[l];
      const double unsure = report_.layers[l].low_confidence = layers[l].unsure;
      const bool still = std::holds_alternative<DirectionAnimation>(layer.direction) && !squeeze.any();
      if (unsure > kMuch && !still)
        warn("layer \"" + layer.name + "\": its direction is little more than a guess on " +
             std::to_string(std::lround(100.0 * unsure)) +
             "% of its surface: see --view confidence, and draw guide curves or mask that part");
    }
  }

  void fitLayer(size_t l, double alpha) {
    constexpr double kNoSqueeze = 1.0001, kShort = 0.01;
    LayerRecipe& layer = recipe_.layers[l];
    const double target = *layer.fit;
    layer.fit.reset();
    if (alpha < kNoSqueeze)
      return warn("layer \"" + layer.name + "\": no pose squeezes it, so that its response is not fitted");
    const ResponseFit fit = fitResponse(alpha, target);
    layer.response = fit.response;
    report_.layers[l].fit = {target, alpha, fit.weight};
    if (fit.weight < target - kShort) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "is squeezed to alpha %.3g only: its weight reaches %.2g instead of %.2g", alpha,
                    fit.weight, target);
      warn("layer \"" + layer.name + "\" " + text);
    }
  }

  void report() {
    report_.vertices = static_cast<uint32_t>(surface_.positions.size());
    report_.triangles = static_cast<uint32_t>(surface_.triangles.size());
    report_.weld_tolerance = weld_.tolerance;
    report_.places = weld_.places;
    report_.points = weld_.points;
    report_.morphs = static_cast<uint32_t>(scene_.rig.morphs.size());
    report_.clips = static_cast<uint32_t>(scene_.rig.clips.size());
    report_.position_error = position_error_;
    glm::vec3 lowest(INFINITY), highest(-INFINITY);
    for (const glm::vec3& p : surface_.positions) {
      lowest = glm::min(lowest, p);
      highest = glm::max(highest, p);
    }
    report_.diagonal = glm::distance(lowest, highest);
    tellTopology();
    const bool some_without_uvs =
        std::any_of(parts_.begin(), parts_.end(), [](const PackedPart& part) { return !part.has_uvs; });
    if (some_without_uvs)
      warn("a mesh has no UVs: it gets weights and alpha shading by vertex, but no wrinkle maps");
  }

  SourceScene scene_;
  Recipe recipe_;
  const CookOptions& options_;
  std::string recipe_file_;
  CookReport report_;
  std::chrono::steady_clock::time_point stage_begin_;
  Weld weld_;
  Surface surface_;
  std::vector<PackedPart> parts_;
  std::vector<PartGeometry> geometry_;
  std::vector<uint32_t> source_vertex_;
  std::vector<glm::u8vec4> colors_;  // AssetView::colors of the parts packed so far; empty while none has any
  size_t packed_vertices_ = 0;
  std::vector<std::pair<uint32_t, uint32_t>> place_points_;  // a slot of the hash
  SceneBaseMaps base_maps_;
  std::vector<std::filesystem::path> dependencies_;
  uint32_t influences_ = 1;
  std::vector<glm::dvec3> rest_offsets_;  // a vertex in source order; empty unless another file is the rest
  double position_error_ = 0.0;
};

}  // namespace

Cooked cook(SourceScene scene, const Recipe& recipe, const CookOptions& options) {
  return Cook(std::move(scene), recipe, options).run();
}

}  // namespace furrow::pipeline
