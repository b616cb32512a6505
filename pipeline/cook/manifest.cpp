#include "pipeline/cook/manifest.h"

#include <map>

#include "pipeline/error.h"
#include "pipeline/recipe/recipe_schema.h"

namespace furrow::pipeline {

namespace {

std::vector<ManifestAsset> assetsOf(const nlohmann::json& json, const std::filesystem::path& file) {
  std::vector<ManifestAsset> assets;
  std::map<std::filesystem::path, std::string> inputs, outputs;  // where each stands
  for (const nlohmann::json& entry : json["assets"]) {
    const std::string at = "assets[" + std::to_string(assets.size()) + ']';
    const auto fail = [&](const std::string& wrong, const char* remedy) {
      throw Error(Exit::kBadData, file.string(), at + wrong, remedy);
    };
    const auto path = [&](const char* key) -> std::filesystem::path {
      if (!entry.contains(key)) return {};
      const auto text = entry[key].get<std::string>();
      if (text.find('\0') != std::string::npos)
        fail(std::string(".") + key + ": has a zero byte", "give the path of a file");
      return (file.parent_path() / std::u8string(text.begin(), text.end())).lexically_normal();
    };
    ManifestAsset asset;
    asset.request.source = {path("sequence"), path("source"), entry.value("fps", Sequence{}.fps)};
    asset.request.recipe = path("recipe");
    if (entry.value("geometry", "") == "raw") asset.request.geometry = GeometryCodec::kRaw;
    asset.output = path("output");
    if (asset.request.source.name().empty()) fail(" has no source", "give \"source\", \"sequence\" or both");
    if (entry.contains("fps") && asset.request.source.pattern.empty())
      fail(".fps: does not go with \"source\" alone", "it goes with \"sequence\"");
    for (const std::filesystem::path& input : {asset.request.source.base, asset.request.recipe})
      if (!input.empty()) inputs.emplace(input, at);
    if (const auto [other, is_new] = outputs.emplace(asset.output, at); !is_new)
      fail(".output: is also the output of " + other->second, "give each asset a file of its own");
    assets.push_back(std::move(asset));
  }
  for (const auto& [output, at] : outputs)
    if (const auto input = inputs.find(output); input != inputs.end())
      throw Error(Exit::kBadData, file.string(), at + ".output: is an input of " + input->second,
                  "give each asset a file of its own");
  return assets;
}

}  // namespace

std::vector<ManifestAsset> readManifest(const std::filesystem::path& file) {
  return assetsOf(readJson(file, manifestShape(), "manifest").value, file);
}

std::vector<ManifestAsset> parseManifest(const std::string& text, const std::filesystem::path& file) {
  return assetsOf(parseJson(text, file, manifestShape(), "manifest").value, file);
}

}  // namespace furrow::pipeline
