#include "pipeline/cook/cook.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <set>

#include "pipeline/bake/response_fit.h"
#include "pipeline/bake/rest_view.h"
#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/weld.h"
#include "pipeline/cook/layer_bake.h"
#include "pipeline/cook/map_bake.h"
#include "pipeline/cook/packing.h"
#include "pipeline/cook/writer.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/parallel.h"
#include "pipeline/recipe/arkit.h"
#include "pipeline/release.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

constexpr size_t kLarge = 1'000'000;  // triangles from which on layers are baked one by one, to save memory

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
    const RestPose rest{recipe_.rest, rest_offsets_};
    std::vector<glm::vec3> source_rest = rest.positions(scene_);
    inspectTriangles(source_rest);
    stage("packing geometry");
    packed_ = packScene(scene_, weld_, recipe_, rest, source_rest, options_.geometry);
    report_.warnings.insert(report_.warnings.end(), packed_.warnings.begin(), packed_.warnings.end());
    for (size_t i = 0; i < packed_.parts.size(); ++i)
      if (scene_.parts[i].material < scene_.materials.size() && packed_.parts[i].has_uvs)
        packed_.parts[i].base_maps = base_maps_.of_material[scene_.parts[i].material];
    release(source_rest);
    stage("measuring the animation");
    Squeeze squeeze;
    if (needsSqueeze()) {
      squeeze = measureSqueeze(scene_, packed_.surface, packed_.source_vertex);
      if (!squeeze.any())
        warn(
            "no clip and no morph target squeezes it: wrinkles will only come from bias, region weights and "
            "drivers");
    }
    stage("baking layers");
    const MaskImages masks = maskImages();
    const LayerInput input{scene_, packed_.surface, packed_.source_vertex, squeeze,
                           masks,  options_.images, recipe_file_};
    std::vector<BakedLayer> layers(recipe_.layers.size());
    std::vector<std::vector<std::filesystem::path>> images(layers.size());
    const bool large = packed_.surface.triangles.size() > kLarge;
    parallelFor(static_cast<uint32_t>(layers.size()), large ? 1 : options_.threads,
                [&](uint32_t l) { layers[l] = bakeLayer(input, recipe_.layers[l], images[l]); });
    for (const auto& files : images) dependencies_.insert(dependencies_.end(), files.begin(), files.end());
    resolveNames();
    fitResponses(layers);
    reportConfidence(squeeze, layers);
    for (size_t l = 0; l < layers.size(); ++l) resolveMaps(input, layers[l], recipe_.layers[l]);
    stage("making maps");
    std::vector<BakedTextureSet> sets =
        bakeMaps(input, recipe_, layers, options_.threads, dependencies_, report_.warnings);
    for (uint32_t s = 0; s < sets.size(); ++s)
      for (uint32_t part : sets[s].parts) packed_.parts[part].texture_set = s;

    stage("packing");
    Cooked cooked;
    cooked.bytes = writeAsset({scene_, packed_.surface, weld_, recipe_, layers, sets, base_maps_.maps,
                               packed_.parts, packed_.source_vertex, packed_.colors, packed_.place_points,
                               packed_.influences, packed_.position_error});
    report();
    release(squeeze, layers, sets, packed_.surface, packed_.parts, weld_, packed_.source_vertex,
            scene_.primitives);
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
    for (const std::filesystem::path& file : dependencies_) {
      const auto embedded = embeddedImage(file);
      for (const std::filesystem::path& read : embedded ? embedded->files : std::vector{file})
        if (std::ranges::find(cooked.dependencies, read) == cooked.dependencies.end())
          cooked.dependencies.push_back(read);
    }
    return cooked;
  }

 private:
  void bakeOwnMaps() {
    EncodedImages unknown;
    base_maps_ = bakeBaseMaps(scene_, recipe_.preview_size, options_.threads,
                              options_.encoded ? *options_.encoded : unknown);
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

  void fitResponses(const std::vector<BakedLayer>& layers) {
    std::vector<size_t> fitted;
    std::vector<MeasuredLayer> measured;
    for (size_t l = 0; l < layers.size(); ++l) {
      report_.layers.push_back({recipe_.layers[l].name, {}, {}});
      if (!recipe_.layers[l].fit) continue;
      fitted.push_back(l);
      measured.push_back({recipe_.layers[l].measure, layers[l].coefficients, layers[l].field.strength});
    }
    if (!fitted.empty()) {
      const Rings rings = makeRings(restView(packed_.surface));
      const auto alpha = largestAlpha(scene_, packed_.surface, packed_.source_vertex, rings, measured);
      for (size_t i = 0; i < fitted.size(); ++i)
        fitLayer(fitted[i], percentile95(packed_.surface, layers[fitted[i]].covered,
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
      if (std::ranges::none_of(layers[l].field.strength, [](float mask) { return mask >= 1.0f / 255.0f; }))
        warn("layer \"" + layer.name +
             "\" shows nowhere: nothing squeezes it along its direction: choose another, or paint a mask");
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
    report_.vertices = static_cast<uint32_t>(packed_.surface.positions.size());
    report_.triangles = static_cast<uint32_t>(packed_.surface.triangles.size());
    report_.weld_tolerance = weld_.tolerance;
    report_.places = weld_.places;
    report_.points = weld_.points;
    report_.morphs = static_cast<uint32_t>(scene_.rig.morphs.size());
    report_.clips = static_cast<uint32_t>(scene_.rig.clips.size());
    report_.position_error = packed_.position_error;
    glm::vec3 lowest(INFINITY), highest(-INFINITY);
    for (const glm::vec3& p : packed_.surface.positions) {
      lowest = glm::min(lowest, p);
      highest = glm::max(highest, p);
    }
    report_.diagonal = glm::distance(lowest, highest);
    tellTopology();
    const bool some_without_uvs = std::any_of(packed_.parts.begin(), packed_.parts.end(),
                                              [](const PackedPart& part) { return !part.has_uvs; });
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
  Packing packed_;
  SceneBaseMaps base_maps_;
  std::vector<std::filesystem::path> dependencies_;
  std::vector<glm::dvec3> rest_offsets_;  // a vertex in source order; empty unless another file is the rest
};

}  // namespace

Cooked cook(SourceScene scene, const Recipe& recipe, const CookOptions& options) {
  return Cook(std::move(scene), recipe, options).run();
}

}  // namespace furrow::pipeline
