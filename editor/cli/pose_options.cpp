#include "editor/cli/pose_options.h"

#include <charconv>
#include <cstdio>

#include "editor/cli/backend.h"
#include "editor/cli/commands.h"
#include "pipeline/error.h"
#include "pipeline/import/take.h"
#include "pipeline/recipe/arkit.h"
#include "pipeline/scene/posing.h"
#include "pipeline/scene/rest.h"

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;

constexpr std::string_view kMorph = "--morph", kRegion = "--region";

// NAME=NUMBER, split at the last '='.
std::pair<std::string, double> assignment(const std::string& text, std::string_view option) {
  const size_t equals = text.rfind('=');
  double value = 0.0;
  const char* end = text.data() + text.size();
  if (equals != std::string::npos && equals > 0) {
    const auto [stop, error] = std::from_chars(text.data() + equals + 1, end, value);
    if (error == std::errc() && stop == end && isFloat(value)) return {text.substr(0, equals), value};
  }
  throw Error(
      Exit::kBadUsage, std::string(option) + " " + text, "is not NAME=NUMBER",
      "write for example " + std::string(option) + (option == kMorph ? " jawOpen=0.5" : " forehead=0.5"));
}

// Indices of all that have the name, or the one that has the number.
std::vector<size_t> select(const std::vector<std::string>& names, const std::string& wanted, const char* kind,
                           const std::string& file) {
  std::vector<size_t> found;
  for (size_t i = 0; i < names.size(); ++i)
    if (names[i] == wanted) found.push_back(i);
  size_t number = 0;
  const auto [stop, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  if (found.empty() && error == std::errc() && stop == wanted.data() + wanted.size() && number < names.size())
    found.push_back(number);
  if (found.empty()) {
    std::vector<std::string> there = names;
    for (size_t i = 0; i < there.size(); ++i)
      if (there[i].empty()) there[i] = std::to_string(i);
    throw Error(Exit::kBadUsage, file, std::string("it has no ") + kind + " \"" + wanted + "\"",
                "it has: " + pipeline::joinNames(there, 80));
  }
  return found;
}

// Poses the morph targets that the take has shapes for; names the shapes that are no morph target on stderr.
void applyTake(const std::string& file, double time, const std::vector<std::string>& names,
               pipeline::Pose& pose) {
  const pipeline::Take take = pipeline::readTake(file);
  const std::vector<float> weights = take.at(time);
  std::vector<std::string> unknown;
  for (size_t s = 0; s < weights.size(); ++s) {
    const std::vector<size_t> found = pipeline::matchShape(names, take.shapes[s]);
    for (size_t m : found) pose.morph_weights[m] = double{weights[s]};
    if (found.empty()) unknown.push_back(take.shapes[s]);
  }
  if (!unknown.empty())
    std::fprintf(stderr, "furrow: %s: warning: the asset has no morph target for %s\n", file.c_str(),
                 pipeline::joinNames(unknown, 80).c_str());
}

}  // namespace

void PoseOptions::add(CLI::App& command) {
  command.add_option("--clip", clip, "Clip to pose with, by name or number")
      ->check([](const std::string& name) {
        return std::string(name.empty() ? "the name of the clip is empty" : "");
      });
  command.add_option("--take", take,
                     "Face shapes over time (CSV as Live Link Face writes it); goes with a clip of the body");
  command.add_option("--time", time, "Time in the clip and the take in seconds, clamped to them (default 0)")
      ->check(requireFloat);
  command.add_option("--morph", morphs, "Weight of a morph target, M=W, by name or number; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--region", regions, "Region weight of a layer, LAYER=W in [-1, 1]; may be repeated")
      ->allow_extra_args(false);
  command
      .add_option(
          "--scale", scale,
          "Uniform scale of the whole instance that the pose contains (default: what the clip gives to "
          "all of it)")
      ->check(requirePositive);
  command
      .add_option("--backend", backend,
                  "Tier to compute on (default auto: FURROW_BACKEND, or the best there is)")
      ->check(CLI::IsMember({"auto", "gpu", "gpu-raster", "cpu"}));
}

void PoseOptions::validate() const {
  for (const std::string& text : morphs) assignment(text, kMorph);
  for (const std::string& text : regions)
    if (std::abs(assignment(text, kRegion).second) > 1.0)
      throw Error(Exit::kBadUsage, "--region " + text, "is not from -1 to 1", "give a weight of the layer");
  checkBackend(backend);
}

preview::PosedFrame poseFrame(const OpenedAsset& opened, const PoseOptions& options) {
  const AssetView& asset = opened.asset.view();
  const std::string file = opened.file.string();
  if (options.time && options.clip.empty() && options.take.empty())
    throw Error(Exit::kBadUsage, "--time", "there is nothing to play", "give --clip or --take");
  pipeline::Pose pose = pipeline::defaultPose(opened.rig);
  if (!options.clip.empty()) {
    std::vector<std::string> names;
    for (const pipeline::Clip& clip : opened.rig.clips) names.push_back(clip.name);
    pipeline::applyClip(opened.rig, opened.rig.clips[select(names, options.clip, "clip", file).front()],
                        options.time.value_or(0.0), pose);
  }
  std::vector<std::string> names;
  for (const Morph& morph : asset.morphs) names.emplace_back(morph.name);
  if (!options.take.empty()) applyTake(options.take, options.time.value_or(0.0), names, pose);
  for (const std::string& text : options.morphs) {
    const auto [name, weight] = assignment(text, kMorph);
    for (size_t m : select(names, name, "morph target", file)) pose.morph_weights[m] = weight;
  }

  std::vector<float> regions(asset.layerCount(), 0.0f);
  names.clear();
  for (const Layer& layer : asset.layers) names.emplace_back(layer.name);
  for (const std::string& text : options.regions) {
    const auto [name, weight] = assignment(text, kRegion);
    for (size_t l : select(names, name, "layer", file)) regions[l] += static_cast<float>(weight);
  }
  const pipeline::PosedRig posed = pipeline::evaluate(opened.rig, pose);
  const double scale = options.scale ? *options.scale : pipeline::wholeScale(opened.rig, posed);
  return preview::poseFrame(asset, posed, regions, static_cast<float>(scale));
}

}  // namespace furrow::cli
