#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "editor/cli/commands.h"
#include "editor/cli/open_asset.h"
#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {
namespace {

struct Options {
  std::string in, out, recipe, init, depfile, report, geometry = "draco";
  pipeline::Sequence sequence;
  uint32_t threads = 0;
  bool force = false, quiet = false;
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
  std::error_code ignored;
  if (!options.init.empty() && !options.force && std::filesystem::exists(options.init, ignored))
    throw pipeline::Error(pipeline::Exit::kBadUsage, options.init, "it exists already",
                          "give --init another name, or --force to replace it");
  pipeline::CookOptions cook_options;
  cook_options.geometry =
      options.geometry == "raw" ? pipeline::GeometryCodec::kRaw : pipeline::GeometryCodec::kDraco;
  cook_options.threads =
      options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  pipeline::Sequence sequence = options.sequence;
  sequence.base = options.in;
  const pipeline::Cooked cooked = cookFile(sequence, options.recipe, cook_options, options.quiet);
  for (const std::string& output : {options.out, options.init})
    for (const std::filesystem::path& input : cooked.dependencies)
      if (std::filesystem::equivalent(input, output, ignored))
        throw pipeline::Error(pipeline::Exit::kBadUsage, output, "the output would overwrite an input",
                              "choose another name for it");
  pipeline::writeFile(options.out, cooked.bytes);
  if (!options.init.empty()) writeText(options.init, pipeline::recipeText(cooked.recipe, options.init));
  if (!options.depfile.empty()) writeText(options.depfile, depfileText(options.out, cooked.dependencies));
  const pipeline::CookReport& report = cooked.report;
  if (!options.report.empty()) writeText(options.report, pipeline::reportText(report, options.out));
  if (options.quiet) return;
  printWarnings(sequence.name(), report.warnings);
  for (const pipeline::LayerReport& layer : report.layers)
    if (layer.fit)
      std::fprintf(stderr,
                   "furrow: %s: layer \"%s\": fitted lambda %.4g, beta %.4g: weight %.2g at alpha %.3g\n",
                   options.out.c_str(), layer.name.c_str(), layer.response.lambda, layer.response.beta,
                   layer.fit->weight, layer.fit->alpha);
  for (const pipeline::TextureReport& t : report.textures)
    if (t.format == TextureFormat::kBc5)
      std::fprintf(stderr, "furrow: %s: maps \"%s\": %u x %u x %u, encoding error %.2f degrees rms\n",
                   options.out.c_str(), t.set.c_str(), t.width, t.height, t.slices, t.rms_error);
  std::fprintf(stderr, "furrow: %s: %u triangles, %u vertices, %u points, %zu bytes, %.2f s\n",
               options.out.c_str(), report.triangles, report.vertices, report.points, report.bytes,
               std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

}  // namespace

Command addCook(CLI::App& app) {
  CLI::App* command = app.add_subcommand("cook", "Turn a mesh into a .furrow asset");
  const auto options = std::make_shared<Options>();
  CLI::Option* in = command->add_option("IN", options->in, "glTF 2.0 (.gltf, .glb), OBJ, PLY, STL or OFF");
  CLI::Option* sequence =
      command->add_option("--sequence", options->sequence.pattern,
                          "Frames of a vertex animation, 'frame_*.obj', which becomes the clip \"sequence\"; "
                          "with IN, that is the relaxed mesh, else the first frame is");
  command->add_option("--fps", options->sequence.fps, "Frames a second of the sequence (default 24)")
      ->needs(sequence)
      ->check(CLI::Range(0.001, 100000.0));
  command->add_option("-o,--output", options->out, "The asset to write")->required();
  command->add_option("--recipe", options->recipe,
                      "Recipe (JSON); without one, one layer worked out from the animation");
  CLI::Option* init = command->add_option("--init", options->init,
                                          "Write the recipe with all that was worked out, to be edited");
  command->add_flag("--force", options->force, "Let --init replace a file")->needs(init);
  command->add_option("--depfile", options->depfile, "Write a Make rule with every file that was read");
  command->add_option("--report", options->report, "Write what was done as JSON");
  command->add_option("--geometry", options->geometry, "draco (default) or raw, which loads without Draco")
      ->check(CLI::IsMember({"draco", "raw"}));
  command
      ->add_option("--threads", options->threads,
                   "Threads for the maps (default: all cores); the bytes do not depend on it")
      ->check(CLI::Range(1, 256));
  command->add_flag("--quiet", options->quiet, "No progress, no warnings, no summary");
  command->callback([in, sequence] {
    if (in->empty() && sequence->empty()) throw CLI::RequiredError("IN or --sequence");
  });
  return [options] { run(*options); };
}

}  // namespace furrow::cli
