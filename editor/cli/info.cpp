#include <cstdio>
#include <nlohmann/json.hpp>

#include "editor/cli/backend.h"
#include "editor/cli/commands.h"
#include "editor/cli/open_asset.h"
#include "editor/cli/outputs.h"
#include "furrow/frame_plan.h"
#include "pipeline/maps/encode.h"
#include "pipeline/recipe/recipe_schema.h"

namespace furrow::cli {
namespace {

nlohmann::json describe(const Texture& texture) {
  return {{"format", pipeline::textureFormatName(texture.format)},
          {"width", texture.width},
          {"height", texture.height},
          {"slices", texture.slices},
          {"bytes", texture.data.size()},
          {"rmsError", texture.rms_error},
          {"largestError", texture.largest_error}};
}

// What eval and render would run on here.
nlohmann::json describeTier() {
  Backend backend("auto");
  if (const Status status = backend.choose(); !status.ok())
    return {{"name", nullptr}, {"reason", status.message}};
  return {{"name", gl::tierName(backend.choice().tier)}, {"reason", backend.choice().reason}};
}

nlohmann::json describe(const OpenedAsset& opened) {
  const AssetView& a = opened.asset.view();
  using nlohmann::json;
  json layers = json::array(), parts = json::array(), sets = json::array(), clips = json::array(),
       morphs = json::array();
  for (const Layer& layer : a.layers)
    layers.push_back({{"name", layer.name},
                      {"measure", pipeline::kMeasureNames[static_cast<size_t>(layer.measure)]},
                      {"lambda", layer.response.lambda},
                      {"beta", layer.response.beta}});
  for (const Part& part : a.parts)
    parts.push_back({{"mesh", part.mesh},
                     {"material", part.material},
                     {"vertices", part.vertex_end - part.vertex_begin},
                     {"triangles", part.triangle_end - part.triangle_begin}});
  size_t texture_bytes = 0;
  for (const TextureSet& set : a.texture_sets) {
    const size_t bytes = set.normals.data.size() + set.shading.data.size() + set.masks.data.size();
    texture_bytes += bytes;
    json masks = json::array();
    for (const Layer& layer : a.layers)
      if (set.masks.slices > 0 && layer.mask_slice != kAbsent)
        masks.push_back({{"layer", layer.name},
                         {"slice", layer.mask_slice / 4},
                         {"channel", std::string(1, "rgba"[layer.mask_slice % 4])}});
    sets.push_back({{"name", set.name},
                    {"normals", describe(set.normals)},
                    {"shading", describe(set.shading)},
                    {"masks", describe(set.masks)},
                    {"maskChannels", masks},
                    {"bytes", bytes}});
  }
  json own_maps = json::array();
  for (const BaseMaps& maps : a.base_maps) {
    own_maps.push_back({{"color", describe(maps.color)}, {"normal", describe(maps.normal)}});
  }
  for (const pipeline::Clip& clip : opened.rig.clips)
    clips.push_back({{"name", clip.name}, {"seconds", clip.duration}});
  for (const Morph& morph : a.morphs) morphs.push_back(morph.name);
  const pipeline::SectionBytes& s = opened.sections;
  uint64_t per_asset = texture_bytes, per_instance = 0;
  const FramePlan plan(a, {});
  for (uint32_t b = 0; b < static_cast<uint32_t>(Buffer::kCount); ++b)
    (plan.buffer(static_cast<Buffer>(b)).lifetime == Lifetime::kPerAsset ? per_asset : per_instance) +=
        plan.buffer(static_cast<Buffer>(b)).bytes;
  return {{"file", opened.file.string()},
          {"source", a.source},
          {"toolVersion", a.tool_version},
          {"formatVersion", kFormatVersion},
          {"bytes", opened.bytes},
          {"vertices", a.vertexCount()},
          {"triangles", a.triangleCount()},
          {"points", a.pointCount()},
          {"influences", a.influences},
          {"paletteEntries", a.palette.size()},
          {"positionError", a.position_error},
          {"morphError", a.morph_error},
          {"sections",
           {{"geometry", s.geometry},
            {"morphTargets", s.morphs},
            {"layers", s.layers},
            {"textures", s.maps},
            {"previewMaps", s.own_maps},
            {"placeHash", s.place_hash},
            {"rig", s.rig},
            {"rest",
             opened.bytes - s.geometry - s.morphs - s.layers - s.maps - s.own_maps - s.place_hash - s.rig}}},
          {"gpuBytesPerAsset", per_asset},
          {"gpuBytesPerInstance", per_instance},
          {"layers", layers},
          {"parts", parts},
          {"textureSets", sets},
          {"previewMaps", own_maps},
          {"clips", clips},
          {"morphTargets", morphs}};
}

void print(const nlohmann::json& j) {
  const auto number = [&](const char* key) { return j[key].get<unsigned long long>(); };
  std::printf("%s: furrow asset, format %llu, cooked by furrow %s from %s\n",
              j["file"].get<std::string>().c_str(), number("formatVersion"),
              j["toolVersion"].get<std::string>().c_str(), j["source"].get<std::string>().c_str());
  std::printf("  %llu bytes:", number("bytes"));
  for (const auto& [name, bytes] : j["sections"].items())
    std::printf(" %s %llu", name.c_str(), bytes.get<unsigned long long>());
  std::printf("\n  GPU memory: %llu bytes an asset, %llu an instance\n", number("gpuBytesPerAsset"),
              number("gpuBytesPerInstance"));
  if (j.contains("tier")) std::printf("  tier here: %s\n", j["tier"]["reason"].get<std::string>().c_str());
  std::printf(
      "  %llu vertices, %llu triangles, %llu points, %llu influences, %llu palette entries; error "
      "of positions %g, of morph targets %g\n",
      number("vertices"), number("triangles"), number("points"), number("influences"),
      number("paletteEntries"), j["positionError"].get<double>(), j["morphError"].get<double>());
  for (const auto& p : j["parts"])
    std::printf("  part   %s / %s: %llu vertices, %llu triangles\n", p["mesh"].get<std::string>().c_str(),
                p["material"].get<std::string>().c_str(), p["vertices"].get<unsigned long long>(),
                p["triangles"].get<unsigned long long>());
  for (const auto& l : j["layers"])
    std::printf("  layer  %s: %s, lambda %g, beta %g\n", l["name"].get<std::string>().c_str(),
                l["measure"].get<std::string>().c_str(), l["lambda"].get<double>(), l["beta"].get<double>());
  for (const auto& s : j["textureSets"]) {
    std::printf("  maps   %s: %llu bytes\n", s["name"].get<std::string>().c_str(),
                s["bytes"].get<unsigned long long>());
    for (const char* kind : {"normals", "shading", "masks"}) {
      const auto& t = s[kind];
      if (t["slices"] == 0) continue;
      std::printf("    %-8s %s, %llu x %llu x %llu, %llu bytes", kind, t["format"].get<std::string>().c_str(),
                  t["width"].get<unsigned long long>(), t["height"].get<unsigned long long>(),
                  t["slices"].get<unsigned long long>(), t["bytes"].get<unsigned long long>());
      if (t["format"] != "RGBA8")
        std::printf(", error %.3g rms, %.3g at most%s", t["rmsError"].get<double>(),
                    t["largestError"].get<double>(), t["format"] == "BC5" ? " (degrees)" : "");
      for (const auto& m : s["maskChannels"])
        if (kind == std::string("masks"))
          std::printf("%s%llu.%s %s", m == s["maskChannels"][0] ? ": " : ", ",
                      m["slice"].get<unsigned long long>(), m["channel"].get<std::string>().c_str(),
                      m["layer"].get<std::string>().c_str());
      std::printf("\n");
    }
  }
  for (const auto& maps : j["previewMaps"])
    for (const char* kind : {"color", "normal"})
      if (const auto& t = maps[kind]; t["slices"] != 0)
        std::printf("  preview %s %s, %llu x %llu, %llu bytes\n", kind,
                    t["format"].get<std::string>().c_str(), t["width"].get<unsigned long long>(),
                    t["height"].get<unsigned long long>(), t["bytes"].get<unsigned long long>());
  for (const auto& c : j["clips"])
    std::printf("  clip   %s: %.3f s\n", c["name"].get<std::string>().c_str(), c["seconds"].get<double>());
  size_t index = 0;
  for (const auto& m : j["morphTargets"])
    std::printf("  morph  %zu %s\n", index++, m.get<std::string>().c_str());
}

}  // namespace

Command addInfo(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("info", "Show what is in an asset, sizes by section, and GPU memory");
  struct Options {
    AssetOptions asset;
    bool json = false, tier = false;
  };
  const auto options = std::make_shared<Options>();
  options->asset.add(*command);
  command->add_flag("--json", options->json, "As JSON");
  command->add_flag("--tier", options->tier,
                    "Also which tier frames would run on here, and why: asks the OpenGL driver");
  return [options] {
    const OpenedAsset opened = options->asset.open();
    nlohmann::json description = describe(opened);
    if (options->tier) description["tier"] = describeTier();
    if (options->json)
      std::printf("%s\n", description.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    else
      print(description);
    finishPrinting();
    printWarnings(options->asset.file, opened.warnings);
  };
}

Command addCheck(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("check", "Tell whether an asset or a source is valid, or exactly what is wrong");
  const auto asset = std::make_shared<AssetOptions>();
  asset->add(*command, "FILE");
  return [asset] {
    const OpenedAsset opened = asset->open();
    std::printf("%s: valid %s, %u triangles\n", asset->file.c_str(), opened.cooked_here ? "source" : "asset",
                opened.asset.view().triangleCount());
    finishPrinting();
    printWarnings(asset->file, opened.warnings);
  };
}

}  // namespace furrow::cli
