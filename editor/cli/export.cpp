#include "editor/cli/commands.h"
#include "editor/cli/open_asset.h"
#include "editor/cli/outputs.h"
#include "pipeline/error.h"
#include "pipeline/gltf_export.h"
#include "pipeline/pack/output_file.h"

namespace furrow::cli {

Command addExport(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("export", "Write the cooked mesh, its rig, maps and weights as GLB for other tools");
  struct Options {
    std::string asset, out;
  };
  const auto options = std::make_shared<Options>();
  command->add_option("ASSET", options->asset, "A .furrow file, or a source to cook in memory")->required();
  command->add_option("-o,--output", options->out, "The .glb file to write")->required()->check(requireName);
  return [options] {
    using pipeline::Error;
    using pipeline::Exit;
    if (std::filesystem::path(options->out).extension() != ".glb")
      throw Error(Exit::kBadUsage, options->out, "GLB is what is written", "give a name that ends in .glb");
    refuseToOverwrite({options->out}, {options->asset});
    const OpenedAsset opened = openAsset(options->asset);
    pipeline::writeFile(options->out, pipeline::exportGlb(opened.asset.view(), opened.rig));
    printWarnings(options->asset, opened.warnings);
  };
}

}  // namespace furrow::cli
