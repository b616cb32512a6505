#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include "editor/cli/commands.h"
#include "editor/cli/cook_manifest.h"
#include "editor/cli/open_asset.h"
#include "editor/cli/outputs.h"
#include "pipeline/cook/cook_cache.h"
#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {
namespace {

struct Options {
  std::string in, out, recipe, init, depfile, report, cache, manifest, geometry = "draco";
  pipeline::Sequence sequence;
  uint32_t threads = 0, jobs = 0;
  bool force = false, quiet = false, no_cache = false;
};

uint32_t cores() {
  return std::max(1u, std::thread::hardware_concurrency());
}

void runManifest(const Options& options) {
  ManifestOptions manifest{options.manifest, options.cache, options.depfile};
  manifest.jobs = options.jobs ? options.jobs : cores();
  manifest.threads = options.threads ? options.threads : cores();
  manifest.quiet = options.quiet;
  if (options.no_cache)
    manifest.cache.clear();
  else if (manifest.cache.empty())
    manifest.cache = pipeline::defaultCacheFolder();
  cookManifest(manifest);
}

// The cache that was asked for, and the place in it of what the request makes.
class CacheUse {
 public:
  CacheUse(const std::string& folder, const pipeline::CookRequest& request) : request_(request) {
    if (folder.empty()) return;
    cache_.emplace(folder);
    files_ = pipeline::filesOf(request_);
    key_ = pipeline::cookKey(request_, files_);
  }

  std::optional<pipeline::CookCache::Entry> find() const {
    return cache_ ? cache_->find(key_) : std::nullopt;
  }
  const std::vector<std::filesystem::path>& files() const { return files_; }

  // Not if an input changed while it was cooked. Returns what to warn of.
  std::vector<std::string> store(const pipeline::Cooked& cooked) const {
    try {
      if (cache_ && pipeline::cookKey(request_, pipeline::filesOf(request_)) == key_)
        cache_->store(key_, {cooked.bytes, cooked.report.warnings});
      return {};
    } catch (const pipeline::Error& error) {
      return {std::string("not kept in the cache: ") + error.what()};
    }
  }

 private:
  pipeline::CookRequest request_;
  std::optional<pipeline::CookCache> cache_;
  std::vector<std::filesystem::path> files_;
  std::string key_;
};

// The depfile goes first: one that is older than its asset could hide an input.
void write(const Options& options, std::span<const std::byte> bytes,
           const std::vector<std::filesystem::path>& inputs) {
  refuseToOverwrite({options.out, options.init, options.depfile, options.report}, inputs);
  if (!options.depfile.empty()) writeText(options.depfile, makeRule(options.out, inputs));
  pipeline::writeFile(options.out, bytes);
}

void run(const Options& options) {
  if (!options.manifest.empty()) return runManifest(options);
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  checkOutputs({options.out, options.init, options.depfile, options.report}, {options.in, options.recipe});
  std::error_code ignored;
  if (!options.init.empty() && !options.force && std::filesystem::exists(options.init, ignored))
    throw pipeline::Error(pipeline::Exit::kBadUsage, options.init, "it exists already",
                          "give --init another name, or --force to replace it");
  pipeline::CookRequest request{options.sequence, options.recipe};
  request.source.base = options.in;
  if (options.geometry == "raw") request.geometry = pipeline::GeometryCodec::kRaw;
  const pipeline::Sequence& source = request.source;
  const CacheUse cache(options.cache, request);
  if (options.init.empty() && options.report.empty())
    if (const auto found = cache.find()) {
      write(options, found->bytes, cache.files());
      if (options.quiet) return;
      printWarnings(source.name(), found->warnings);
      std::fprintf(stderr, "furrow: %s: from the cache, %zu bytes, %.2f s\n", options.out.c_str(),
                   found->bytes.size(), seconds());
      return;
    }

  pipeline::CookOptions cook_options;
  cook_options.geometry = request.geometry;
  cook_options.threads = options.threads ? options.threads : cores();
  const pipeline::Cooked cooked = cookFile(source, options.recipe, cook_options, options.quiet);
  write(options, cooked.bytes, cooked.dependencies);
  if (!options.init.empty()) writeText(options.init, pipeline::recipeText(cooked.recipe, options.init));
  const pipeline::CookReport& report = cooked.report;
  if (!options.report.empty()) writeText(options.report, pipeline::reportText(report, options.out));
  const std::vector<std::string> not_kept = cache.store(cooked);
  if (options.quiet) return;
  printWarnings(source.name(), report.warnings);
  printWarnings(options.out, not_kept);
  for (const pipeline::LayerReport& layer : report.layers)
    if (layer.fit)
      std::fprintf(stderr,
                   "furrow: %s: layer \"%s\": fitted lambda %.4g, beta %.4g: weight %.2g at alpha %.3g\n",
                   options.out.c_str(), layer.name.c_str(), layer.response.lambda, layer.response.beta,
                   layer.fit->weight, layer.fit->alpha);
  for (const pipeline::TextureReport& t : report.textures)
    if (t.format == TextureFormat::kBc5 && !t.own)
      std::fprintf(stderr, "furrow: %s: maps \"%s\": %u x %u x %u, encoding error %.2f degrees rms\n",
                   options.out.c_str(), t.set.c_str(), t.width, t.height, t.slices, t.rms_error);
  std::fprintf(stderr, "furrow: %s: %u triangles, %u vertices, %u points, %zu bytes, %.2f s\n",
               options.out.c_str(), report.triangles, report.vertices, report.points, report.bytes,
               seconds());
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
      ->check(requireFloat)
      ->check(CLI::Range(0.001, 100000.0));
  CLI::Option* out =
      command->add_option("-o,--output", options->out, "The asset to write")->check(requireName);
  CLI::Option* recipe = command->add_option(
      "--recipe", options->recipe, "Recipe (JSON); without one, one layer worked out from the animation");
  CLI::Option* init =
      command
          ->add_option("--init", options->init, "Write the recipe with all that was worked out, to be edited")
          ->check(requireName);
  command->add_flag("--force", options->force, "Let --init replace a file")->needs(init);
  command->add_option("--depfile", options->depfile, "Write a Make rule with every file that was read")
      ->check(requireName);
  CLI::Option* report =
      command->add_option("--report", options->report, "Write what was done as JSON")->check(requireName);
  CLI::Option* geometry =
      command
          ->add_option("--geometry", options->geometry, "draco (default) or raw, which loads without Draco")
          ->check(CLI::IsMember({"draco", "raw"}));
  command
      ->add_option(
          "--threads", options->threads,
          "Threads for the maps, of all cooks together (default: all cores); the bytes do not depend on it")
      ->check(CLI::Range(1, 256));
  CLI::Option* manifest = command->add_option("--manifest", options->manifest,
                                              "Cook what this file (JSON) lists, in place of IN and -o");
  for (CLI::Option* other : {in, sequence, out, recipe, init, report, geometry}) manifest->excludes(other);
  command->add_option("-j,--jobs", options->jobs, "Cooks at a time (default: all cores)")
      ->needs(manifest)
      ->check(CLI::Range(1, 256));
  CLI::Option* cache = command->add_option("--cache", options->cache,
                                           "Folder of finished cooks, which are not done again; with "
                                           "--manifest it is by default $XDG_CACHE_HOME/furrow or "
                                           "$HOME/.cache/furrow");
  command->add_flag("--no-cache", options->no_cache, "Cook everything in the manifest")
      ->needs(manifest)
      ->excludes(cache);
  command->add_flag("--quiet", options->quiet, "No progress, no warnings, no summary");
  command->callback([in, sequence, out, manifest] {
    if (!manifest->empty()) return;
    if (in->empty() && sequence->empty()) throw CLI::RequiredError("IN, --sequence or --manifest");
    if (out->empty()) throw CLI::RequiredError("--output");
  });
  return [options] { run(*options); };
}

}  // namespace furrow::cli
