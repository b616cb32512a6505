#include <charconv>
#include <map>
#include <optional>
#include <thread>

#include "editor/cli/backend.h"
#include "editor/cli/commands.h"
#include "editor/cli/outputs.h"
#include "editor/cli/pose_options.h"
#include "editor/preview/software_picture.h"
#include "pipeline/error.h"

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;

const std::map<std::string, preview::Shading> kShadings = {{"interpolated", preview::Shading::kInterpolated},
                                                           {"blend", preview::Shading::kBlend},
                                                           {"alpha", preview::Shading::kAlpha},
                                                           {"none", preview::Shading::kNone}};
const std::map<std::string, preview::View> kViews = {{"beauty", preview::View::kBeauty},
                                                     {"weight", preview::View::kWeight},
                                                     {"direction", preview::View::kDirection},
                                                     {"point", preview::View::kPoint},
                                                     {"mask", preview::View::kMask},
                                                     {"bias", preview::View::kBias},
                                                     {"confidence", preview::View::kConfidence},
                                                     {"morph", preview::View::kMorph}};

struct Options {
  AssetOptions asset;
  std::string out, size = "1024x1024", layer;
  std::string shading, lighting = "ggx", view = "beauty";
  std::optional<float> yaw, pitch, distance;
  float zoom = 1.0f;
  std::vector<float> target;
  PoseOptions pose;
};

void parseSize(const std::string& text, uint32_t& width, uint32_t& height) {
  const char* end = text.data() + text.size();
  const auto [x, first_error] = std::from_chars(text.data(), end, width);
  if (first_error == std::errc() && x != end && *x == 'x') {
    const auto [stop, error] = std::from_chars(x + 1, end, height);
    if (error == std::errc() && stop == end && width >= 1 && height >= 1 && width <= 4096 && height <= 4096)
      return;
  }
  throw Error(Exit::kBadUsage, "--size " + text, "is not WIDTHxHEIGHT with sides from 1 to 4096",
              "write for example --size 1024x1024");
}

void run(const Options& options) {
  preview::RenderOptions render;
  parseSize(options.size, render.width, render.height);
  options.pose.validate();
  pipeline::requirePngName(options.out);
  checkOutputs({options.out}, {options.asset.file, options.asset.recipe, options.pose.take});
  Backend backend(options.pose.backend);
  backend.require();
  render.lighting = options.lighting == "blinn" ? preview::Lighting::kBlinn : preview::Lighting::kGgx;
  render.view = kViews.at(options.view);
  // The cpu tier draws without OpenGL what can be drawn without it.
  const auto inSoftware = [&](gl::Tier tier) {
    render.tier = tier;
    render.shading = !options.shading.empty() ? kShadings.at(options.shading)
                     : tier == gl::Tier::kCpu ? preview::Shading::kAlpha
                                              : preview::Shading::kInterpolated;
    return tier == gl::Tier::kCpu && !preview::whyNotInSoftware(render);
  };
  if (!inSoftware(backend.choice().tier)) backend.needContext();
  const OpenedAsset opened = options.asset.open();
  const AssetView& asset = opened.asset.view();
  const preview::PosedFrame frame = poseFrame(opened, options.pose);
  if (!options.layer.empty()) {
    while (render.layer < asset.layerCount() && asset.layers[render.layer].name != options.layer)
      ++render.layer;
    if (render.layer == asset.layerCount())
      throw Error(Exit::kBadUsage, options.asset.file, "it has no layer \"" + options.layer + "\"",
                  "see 'furrow info'");
  }

  std::vector<Float3> posed(asset.vertexCount());
  const DeformJob deform{&asset, frame.palette, frame.morph_weights, posed, {}, {}};
  if (const Status status = deform.validate(); !status.ok())
    throw Error(Exit::kBadData, options.asset.file, status.message, "cook it again");
  deform.run(0, asset.vertexCount());
  const preview::Facing facing =
      options.yaw || options.pitch ? preview::Facing() : preview::facing(posed, asset.indices);
  render.camera =
      preview::fitCamera(posed, static_cast<float>(render.width) / static_cast<float>(render.height),
                         options.yaw.value_or(facing.yaw), options.pitch.value_or(facing.pitch));
  render.camera.distance = options.distance.value_or(render.camera.distance / options.zoom);
  if (options.target.size() == 3)
    render.camera.target = {static_cast<float>(options.target[0] - frame.origin[0]),
                            static_cast<float>(options.target[1] - frame.origin[1]),
                            static_cast<float>(options.target[2] - frame.origin[2])};
  const pipeline::Image picture = backend.run([&](gl::Tier tier) {
    if (inSoftware(tier))
      return preview::softwarePicture(asset, frame.input, render, std::thread::hardware_concurrency());
    backend.needContext();
    return preview::Renderer(asset).render(frame.input, render);
  });
  pipeline::writeImage(options.out, picture);
  backend.report();
  printWarnings(options.asset.file, opened.warnings);
}

}  // namespace

Command addRender(CLI::App& app) {
  CLI::App* command = app.add_subcommand("render", "A picture of the asset in one pose");
  const auto options = std::make_shared<Options>();
  std::vector<std::string> shadings, views;
  for (const auto& [name, value] : kShadings) shadings.push_back(name);
  for (const auto& [name, value] : kViews) views.push_back(name);
  options->asset.add(*command);
  command->add_option("-o,--output", options->out, "PNG file to write")->required()->check(requireName);
  command
      ->add_option("--shading", options->shading,
                   "How wrinkles are drawn (default: interpolated, on the cpu tier alpha)")
      ->check(CLI::IsMember(shadings));
  command
      ->add_option("--lighting", options->lighting,
                   "Reflection: ggx (default), or blinn with Larsson's fading")
      ->check(CLI::IsMember({"ggx", "blinn"}));
  command->add_option("--view", options->view, "What is drawn (default beauty)")->check(CLI::IsMember(views));
  command->add_option("--layer", options->layer,
                      "Layer that the views of one layer show (default: the first)");
  command->add_option("--size", options->size, "WIDTHxHEIGHT in pixels (default 1024x1024)");
  command
      ->add_option(
          "--yaw", options->yaw,
          "Orbit to the side in degrees; 0 shows the front (default: a sheet seen edge-on shows its side)")
      ->check(requireFloat)
      ->check(CLI::Range(-360.0, 360.0));
  command->add_option("--pitch", options->pitch, "Orbit upwards in degrees")
      ->check(requireFloat)
      ->check(CLI::Range(-89.0, 89.0));
  CLI::Option* zoom =
      command->add_option("--zoom", options->zoom, "Nearer (above 1) or farther than what fits the picture")
          ->check(requireFloat)
          ->check(CLI::Range(0.05, 50.0));
  command
      ->add_option("--distance", options->distance,
                   "From the camera to what it looks at, in units of the asset; with --yaw and --target the "
                   "camera stands still for all frames of a clip (default: what fits the pose)")
      ->check(requirePositive)
      ->excludes(zoom);
  command->add_option("--target", options->target, "X Y Z to look at, in root space (default: the middle)")
      ->expected(3)
      ->check(requireFloat);
  options->pose.add(*command);
  return [options] { run(*options); };
}

}  // namespace furrow::cli
