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
#include "pipeline/cook/kept_results.h"
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
constexpr size_t kMostEncoded = 32;   // images, a few MB each

class Cook {
 public:
  Cook(SourceScene scene, const Recipe& recipe, const CookOptions& options)
      : scene_(std::move(scene)),
        recipe_(recipe),
        options_(options),
        recipe_file_(recipe.file.empty() ? scene_.file.string() : recipe.file.string()),
        memory_(options.memory ? options.memory->kept() : own_memory_) {}

  Cooked run() {
    check();
    stage("reading the model's maps");
    bakeOwnMaps();
    findGround();
    stage("baking layers");
    const MaskImages masks = maskImages();
    const LayerInput input{ground_->scene,
                           ground_->packed.surface,
                           ground_->packed.source_vertex,
                           ground_->squeeze,
                           masks,
                           options_.images,
                           recipe_file_};
    std::vector<BakedLayer> layers = bakeLayers(input);
    resolveNames();
    fitResponses(layers);
    reportConfidence(layers);
    for (size_t l = 0; l < layers.size(); ++l) resolveMaps(input, layers[l], recipe_.layers[l]);
    stage("making maps");
    std::vector<BakedTextureSet> sets = bakeSets(input, layers);

    stage("packing");
    Cooked cooked;
    cooked.bytes = pack(layers, sets);
    report();
    cooked.dependencies = ground_->scene.dependencies;
    const std::string name = ground_->scene.file.string();
    release(layers, sets, kept_, ground_);
    own_memory_.forgetScene();
    stage("loading it again");
    if (const Status status = cooked.asset.load(cooked.bytes); !status.ok())
      throw Error(Exit::kBadData, name,
                  std::string("the asset made of it does not load (") + status.message + ")",
                  "report this as a fault of furrow");
    endStage();
    reportAsset(cooked);
    cooked.recipe = std::move(recipe_);
    cooked.report = std::move(report_);
    addDependencies(cooked);
    return cooked;
  }

 private:
  void bakeOwnMaps() {
    if (memory_.encoded.size() > kMostEncoded) memory_.encoded.clear();
    base_maps_ = bakeBaseMaps(scene_, recipe_.preview_size, options_.threads, memory_.encoded);
    for (std::string& warning : base_maps_.warnings) warn(std::move(warning));
    dependencies_.insert(dependencies_.end(), base_maps_.dependencies.begin(), base_maps_.dependencies.end());
    release(scene_.images);
  }

  std::vector<BakedTextureSet> bakeSets(const LayerInput& input, const std::vector<BakedLayer>& layers) {
    std::vector<PackedPart>& parts = ground_->packed.parts;
    for (PackedPart& part : parts) part.texture_set = kAbsent;
    std::vector<BakedTextureSet> sets =
        bakeMaps(input, recipe_, layers, options_.threads, dependencies_, report_.warnings, memory_.patterns);
    own_memory_.patterns.clear();
    for (uint32_t s = 0; s < sets.size(); ++s)
      for (uint32_t part : sets[s].parts) parts[part].texture_set = s;
    return sets;
  }

  std::vector<std::byte> pack(const std::vector<BakedLayer>& layers,
                              const std::vector<BakedTextureSet>& sets) const {
    const Packing& packed = ground_->packed;
    return writeAsset({ground_->scene, packed.surface, ground_->weld, recipe_, layers, sets, base_maps_.maps,
                       packed.parts, packed.source_vertex, packed.colors, packed.place_points,
                       packed.influences, packed.position_error, packed.place_error},
                      options_.threads);
  }

  void reportAsset(const Cooked& cooked) {
    const AssetView& asset = cooked.asset.view();
    const auto tell = [&](const std::string& set, const Texture& texture, bool own) {
      if (texture.slices > 0)
        report_.textures.push_back({set, texture.format, texture.width, texture.height, texture.slices,
                                    texture.data.size(), texture.rms_error, texture.largest_error, own});
    };
    for (const TextureSet& set : asset.texture_sets)
      for (const Texture* texture : {&set.normals, &set.shading, &set.masks})
        tell(std::string(set.name), *texture, false);
    for (size_t i = 0; i < base_maps_.maps.size(); ++i)
      for (const Texture* texture : {&asset.base_maps[i].color, &asset.base_maps[i].normal})
        tell(base_maps_.maps[i].material, *texture, true);
    report_.bytes = cooked.bytes.size();
    report_.morph_error = double{asset.morph_error};
  }

  void addDependencies(Cooked& cooked) const {
    if (!cooked.recipe.file.empty()) cooked.dependencies.push_back(cooked.recipe.file);
    for (const std::filesystem::path& file : dependencies_) {
      const auto embedded = embeddedImage(file);
      for (const std::filesystem::path& read : embedded ? embedded->files : std::vector{file})
        if (std::ranges::find(cooked.dependencies, read) == cooked.dependencies.end())
          cooked.dependencies.push_back(read);
    }
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
    checkHidden();
    const auto* rest = std::get_if<RestClip>(&recipe_.rest);
    const Clip* clip = rest ? findClip(scene_.rig, rest->clip) : nullptr;
    if (clip && rest->time > clip->duration + 0.001) {
      char text[80];
      std::snprintf(text, sizeof text, " ends at %.4g s, before %.4g s: its last pose is taken",
                    clip->duration, rest->time);
      warn("rest: clip \"" + clip->name + '"' + text);
    }
    if (scene_.rig.palette.size() > kMaxPaletteEntries || scene_.rig.morphs.size() > 65535)
      throw Error(Exit::kBadData, scene_.file.string(), "it has more than 65536 joints or morph targets",
                  "split it into several files");
  }

  const Material* materialOf(const SourceScene& scene, const Part& part) const {
    return part.material < scene.materials.size() ? &scene.materials[part.material] : nullptr;
  }

  bool isHidden(const SourceScene& scene, const Part& part) const {
    const Material* material = materialOf(scene, part);
    return std::ranges::any_of(recipe_.hidden, [&](const std::string& name) {
      return name == part.mesh || (material && name == material->name);
    });
  }

  void checkHidden() const {
    if (recipe_.hidden.empty()) return;
    std::set<std::string> known;
    for (const Part& part : scene_.parts) {
      known.insert(part.mesh);
      if (const Material* material = materialOf(scene_, part)) known.insert(material->name);
    }
    for (const std::string& name : recipe_.hidden)
      if (!known.contains(name))
        throw Error(Exit::kBadData, recipe_file_, "hidden: there is no mesh or material \"" + name + '"',
                    "the file has: " + joinNames({known.begin(), known.end()}));
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

  void findGround() {
    const std::string key = groundKey(recipe_, options_.geometry);
    if (memory_.ground && !key.empty() && key == memory_.ground_key) {
      ground_ = memory_.ground;
    } else {
      memory_.forgetScene();
      ground_ =
          std::make_shared<Ground>(makeGround(std::move(scene_), recipe_, options_.geometry, recipe_file_,
                                              options_.threads, [&](const char* name) { stage(name); }));
      memory_.ground = ground_;
      memory_.ground_key = key;
    }
    recipe_.weld_tolerance = ground_->weld.tolerance;
    report_.topology = ground_->topology;
    report_.polygons = ground_->scene.polygons;
    report_.warnings.insert(report_.warnings.end(), ground_->warnings.begin(), ground_->warnings.end());
    dependencies_.insert(dependencies_.end(), ground_->dependencies.begin(), ground_->dependencies.end());
    for (size_t i = 0; i < ground_->packed.parts.size(); ++i) {
      PackedPart& part = ground_->packed.parts[i];
      const Part& source = ground_->scene.parts[i];
      const Material* material = materialOf(ground_->scene, source);
      part.base_maps = material && part.has_uvs ? base_maps_.of_material[source.material] : kAbsent;
      part.base_color.a = isHidden(ground_->scene, source) ? 0.0f : material ? material->base_color.a : 1.0f;
    }
  }

  // `kept_` are those in the memory.
  std::vector<BakedLayer> bakeLayers(const LayerInput& input) {
    kept_.resize(recipe_.layers.size());
    std::vector<std::string> keys(kept_.size());
    const bool large = input.surface.triangles.size() > kLarge;
    parallelFor(static_cast<uint32_t>(kept_.size()), large ? 1 : options_.threads, [&](uint32_t l) {
      if (options_.memory) keys[l] = layerKey(input, recipe_.layers[l]);
      const auto found = memory_.layers.find(keys[l]);
      if (found != memory_.layers.end() && !keys[l].empty()) {
        kept_[l] = found->second;
      } else {
        kept_[l] = std::make_shared<KeptLayer>();
        kept_[l]->baked = bakeLayer(input, recipe_.layers[l], kept_[l]->images);
      }
    });
    memory_.layers.clear();
    std::vector<BakedLayer> layers;
    for (size_t l = 0; l < kept_.size(); ++l) {
      dependencies_.insert(dependencies_.end(), kept_[l]->images.begin(), kept_[l]->images.end());
      if (options_.memory) {
        memory_.layers.emplace(keys[l], kept_[l]);
        layers.push_back(kept_[l]->baked);
      } else {
        layers.push_back(std::move(kept_[l]->baked));
      }
    }
    return layers;
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
    for (const Part& part : ground_->scene.parts) {
      add(meshes, part.mesh);
      add(materials, part.material < ground_->scene.materials.size()
                         ? ground_->scene.materials[part.material].name
                         : "");
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
      if (!recipe_.layers[l].fit || kept_[l]->alpha) continue;
      fitted.push_back(l);
      measured.push_back({recipe_.layers[l].measure, layers[l].coefficients, layers[l].field.strength});
    }
    if (!fitted.empty()) {
      const Surface& surface = ground_->packed.surface;
      const Rings rings = makeRings(restView(surface));
      const auto alpha = largestAlpha(ground_->scene, surface, ground_->packed.source_vertex, rings, measured,
                                      options_.threads);
      for (size_t i = 0; i < fitted.size(); ++i) {
        const BakedLayer& layer = layers[fitted[i]];
        kept_[fitted[i]]->alpha = percentile95(surface, layer.covered, layer.field.strength, alpha[i]);
      }
    }
    for (size_t l = 0; l < layers.size(); ++l) {
      if (recipe_.layers[l].fit) fitLayer(l, *kept_[l]->alpha);
      report_.layers[l].response = recipe_.layers[l].response;
    }
  }

  void reportConfidence(const std::vector<BakedLayer>& layers) {
    constexpr double kMuch = 0.5;
    for (size_t l = 0; l < layers.size(); ++l) {
      const LayerRecipe& layer = recipe_.layers[l];
      const double unsure = report_.layers[l].low_confidence = layers[l].unsure;
      const bool still = std::holds_alternative<DirectionAnimation>(layer.direction) && !ground_->squeeze.any;
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
    const Packing& packed = ground_->packed;
    report_.vertices = static_cast<uint32_t>(packed.surface.positions.size());
    report_.triangles = static_cast<uint32_t>(packed.surface.triangles.size());
    report_.weld_tolerance = ground_->weld.tolerance;
    report_.places = ground_->weld.places;
    report_.points = ground_->weld.points;
    report_.morphs = static_cast<uint32_t>(ground_->scene.rig.morphs.size());
    report_.clips = static_cast<uint32_t>(ground_->scene.rig.clips.size());
    report_.position_error = packed.position_error;
    glm::vec3 lowest(INFINITY), highest(-INFINITY);
    for (const glm::vec3& p : packed.surface.positions) {
      lowest = glm::min(lowest, p);
      highest = glm::max(highest, p);
    }
    report_.diagonal = glm::distance(lowest, highest);
    tellTopology();
    const bool some_without_uvs = std::any_of(packed.parts.begin(), packed.parts.end(),
                                              [](const PackedPart& part) { return !part.has_uvs; });
    if (some_without_uvs)
      warn("a mesh has no UVs: it gets weights and alpha shading by vertex, but no wrinkle maps");
  }

  SourceScene scene_;  // until there is a ground
  Recipe recipe_;
  const CookOptions& options_;
  std::string recipe_file_;
  CookReport report_;
  std::chrono::steady_clock::time_point stage_begin_;
  SceneBaseMaps base_maps_;
  std::vector<std::filesystem::path> dependencies_;
  KeptResults own_memory_;  // where nobody gave one
  KeptResults& memory_;
  std::shared_ptr<Ground> ground_;
  std::vector<std::shared_ptr<KeptLayer>> kept_;  // a layer
};

}  // namespace

Cooked cook(SourceScene scene, const Recipe& recipe, const CookOptions& options) {
  return Cook(std::move(scene), recipe, options).run();
}

}  // namespace furrow::pipeline
