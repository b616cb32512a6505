#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "editor/cli/commands.h"
#include "editor/cli/open_asset.h"
#include "pipeline/error.h"
#include "pipeline/maps/encode.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {
namespace {

struct Options {
  std::string in, out, recipe, depfile, report, geometry = "draco";
  uint32_t threads = 0;
  bool quiet = false;
};

void writeText(const std::string& file, const std::string& text) {
  pipeline::writeFile(file, std::as_bytes(std::span(text)));
}

// A Make rule; spaces, '#' and '$' escaped as Make and Ninja want them.
std::string depfileText(const std::string& target, const std::vector<std::filesystem::path>& dependencies) {
  const auto escaped = [](const std::string& path) {
    std::string text;
    for (char c : path) {
      if (c == ' ' || c == '#') text += '\\';
      text += c;
      if (c == '$') text += '$';
    }
    return text;
  };
  std::string text = escaped(target) + ":";
  for (const auto& file : dependencies) text += " \\\n  " + escaped(file.string());
  return text + "\n";
}

void run(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code error;
    return !a.empty() && !b.empty() && std::filesystem::equivalent(a, b, error) && !error;
  };
  if (same(options.in, options.out) || same(options.recipe, options.out))
    throw pipeline::Error(pipeline::Exit::kBadUsage, options.out, "the output would overwrite an input",
                          "choose another name for -o");
  pipeline::CookOptions cook_options;
  cook_options.geometry =
      options.geometry == "raw" ? pipeline::GeometryCodec::kRaw : pipeline::GeometryCodec::kDraco;
  cook_options.threads =
      options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  const pipeline::Cooked cooked = cookFile(options.in, options.recipe, cook_options, options.quiet);
  pipeline::writeFile(options.out, cooked.bytes);
  if (!options.depfile.empty()) writeText(options.depfile, depfileText(options.out, cooked.dependencies));
  const pipeline::CookReport& report = cooked.report;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!options.report.empty()) {
    nlohmann::json textures = nlohmann::json::array();
    for (const pipeline::TextureReport& t : report.textures)
      textures.push_back({{"set", t.set},
                          {"format", pipeline::textureFormatName(t.format)},
                          {"width", t.width},
                          {"height", t.height},
                          {"slices", t.slices},
                          {"bytes", t.bytes},
                          {"rmsError", t.rms_error},
                          {"largestError", t.largest_error}});
    const nlohmann::json json = {{"asset", options.out},
                                 {"bytes", cooked.bytes.size()},
                                 {"vertices", report.vertices},
                                 {"triangles", report.triangles},
                                 {"degenerateTriangles", report.degenerate_triangles},
                                 {"places", report.places},
                                 {"points", report.points},
                                 {"morphTargets", report.morphs},
                                 {"clips", report.clips},
                                 {"positionError", report.position_error},
                                 {"diagonal", report.diagonal},
                                 {"textures", textures},
                                 {"seconds", seconds},
                                 {"warnings", report.warnings}};
    writeText(options.report, json.dump(2) + "\n");
  }
  if (!options.quiet) {
    for (const pipeline::TextureReport& t : report.textures)
      if (t.format == TextureFormat::kBc5)
        std::fprintf(stderr, "furrow: %s: maps \"%s\": %u x %u x %u, encoding error %.2f degrees rms\n",
                     options.out.c_str(), t.set.c_str(), t.width, t.height, t.slices, t.rms_error);
    std::fprintf(stderr, "furrow: %s: %u triangles, %u vertices, %u points, %zu bytes, %.2f s\n",
                 options.out.c_str(), report.triangles, report.vertices, report.points, cooked.bytes.size(),
                 seconds);
  }
}

}  // namespace

Command addCook(CLI::App& app) {
  CLI::App* command = app.add_subcommand("cook", "Turn a mesh into a .furrow asset");
  const auto options = std::make_shared<Options>();
  command->add_option("IN", options->in, "glTF 2.0 (.gltf, .glb), OBJ, PLY, STL or OFF")->required();
  command->add_option("-o,--output", options->out, "The asset to write")->required();
  command->add_option("--recipe", options->recipe,
                      "Recipe (JSON); without one, one layer worked out from the animation");
  command->add_option("--depfile", options->depfile, "Write a Make rule with every file that was read");
  command->add_option("--report", options->report, "Write what was done as JSON");
  command->add_option("--geometry", options->geometry, "draco (default) or raw, which loads without Draco")
      ->check(CLI::IsMember({"draco", "raw"}));
  command
      ->add_option("--threads", options->threads,
                   "Threads for the maps (default: all cores); the bytes do not depend on it")
      ->check(CLI::Range(1, 256));
  command->add_flag("--quiet", options->quiet, "No progress, no warnings, no summary");
  return [options] { run(*options); };
}

}  // namespace furrow::cli
