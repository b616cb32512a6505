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
    AssetOptions asset;
    std::string out;
  };
  const auto options = std::make_shared<Options>();
  options->asset.add(*command);
  command->add_option("-o,--output", options->out, "The .glb file to write")->required()->check(requireName);
  return [options] {
    using pipeline::Error;
    using pipeline::Exit;
    if (std::filesystem::path(options->out).extension() != ".glb")
      throw Error(Exit::kBadUsage, options->out, "GLB is what is written", "give a name that ends in .glb");
    checkOutputs({options->out}, {options->asset.file, options->asset.recipe});
    const OpenedAsset opened = options->asset.open();
    pipeline::writeFile(options->out, pipeline::exportGlb(opened.asset.view(), opened.rig));
    printWarnings(options->asset.file, opened.warnings);
  };
}

}  // namespace furrow::cli
