#include "furrow/bind.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <memory>

#include "editor/cli/commands.h"
#include "editor/cli/open_asset.h"
#include "editor/cli/outputs.h"
#include "pipeline/bake/weld.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;

struct Options {
  AssetOptions asset;
  std::string mesh, out, up = "y";
  double scale = 1.0, tolerance = 0.0;
  std::vector<double> matrix;  // 12, row-major
};

// Columns at right angles and of one length.
bool isSimilarity(const Affine& affine) {
  const glm::dmat3 m(affine.m[0], affine.m[4], affine.m[8], affine.m[1], affine.m[5], affine.m[9],
                     affine.m[2], affine.m[6], affine.m[10]);
  const double square = glm::dot(m[0], m[0]);
  const double bound = 1e-4 * square;
  bool similar = square > 0.0 && std::isfinite(square);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) similar &= std::abs(glm::dot(m[i], m[j]) - (i == j ? square : 0.0)) <= bound;
  return similar;
}

Affine toRoot(const Options& options) {
  Affine affine;
  if (!options.matrix.empty()) {
    std::ranges::transform(options.matrix, affine.m, [](double x) { return static_cast<float>(x); });
    if (!isSimilarity(affine))
      throw Error(Exit::kBadUsage, "--matrix", "it is not a similarity",
                  "give 12 numbers, row by row: a rotation or reflection times one scale, and a translation");
    return affine;
  }
  const float s = static_cast<float>(options.scale);
  if (options.up == "z")  // x stays, the mesh's z is up, its -y is to the viewer
    return {{s, 0, 0, 0, 0, 0, s, 0, 0, -s, 0, 0}};
  return {{s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0}};
}

struct Mesh {
  std::vector<Float3> positions;
  std::vector<uint32_t> indices;
};

Mesh readMesh(const std::string& file) {
  const pipeline::SourceScene scene = pipeline::import(file);
  Mesh mesh;
  for (const glm::vec3& p : pipeline::sourcePositions(scene)) mesh.positions.push_back({p.x, p.y, p.z});
  uint32_t first_vertex = 0;
  for (const pipeline::Part& part : scene.parts) {
    const pipeline::Primitive& primitive = scene.primitives[part.primitive];
    for (uint32_t index : primitive.indices) mesh.indices.push_back(first_vertex + index);
    first_vertex += static_cast<uint32_t>(primitive.positions.size());
  }
  return mesh;
}

std::string csv(const std::vector<uint32_t>& points) {
  std::string text = "vertex,point\n";
  for (size_t v = 0; v < points.size(); ++v)
    text += std::to_string(v) + ',' + std::to_string(points[v]) + '\n';
  return text;
}

void run(const Options& options) {
  const Affine to_root = toRoot(options);
  checkOutputs({options.out}, {options.asset.file, options.asset.recipe, options.mesh});
  const OpenedAsset opened = options.asset.open();
  const AssetView& asset = opened.asset.view();
  const Mesh mesh = readMesh(options.mesh);
  BindJob job{&asset, mesh.positions, mesh.indices, to_root, static_cast<float>(options.tolerance), {}, {}};
  std::vector<uint32_t> scratch(job.scratchSize()), points(mesh.positions.size());
  job.scratch = scratch;
  job.points = points;
  if (const Status status = job.validate(); !status.ok())
    throw Error(Exit::kBadData, options.asset.file, status.message,
                "cook it again from its source with 'furrow cook'");
  const BindCounts counts = job.run();
  std::printf("vertices %zu\nmatched %u\nambiguous %u\nunmatched %u\n", points.size(), counts.matched,
              counts.ambiguous, counts.unmatched);
  finishPrinting();
  if (counts.matched != points.size()) {
    const auto first = std::ranges::find_if(points, [](uint32_t point) { return point >= kAmbiguous; });
    const Float3 p = transformed(to_root, mesh.positions[static_cast<size_t>(first - points.begin())]);
    char where[200];
    std::snprintf(where, sizeof where,
                  "%u of its %zu vertices are not in the asset and %u could be several, the first is %zu at "
                  "(%.9g, %.9g, %.9g)",
                  counts.unmatched, points.size(), counts.ambiguous,
                  static_cast<size_t>(first - points.begin()), p.x, p.y, p.z);
    throw Error(Exit::kBadData, options.mesh, where,
                "for other units or axes give --scale, --up or --matrix, for rounded positions --tolerance");
  }
  if (!options.out.empty()) writeText(options.out, csv(points));
}

}  // namespace

Command addBind(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("bind", "Find the points of another file's vertices through the place hash");
  const auto options = std::make_shared<Options>();
  options->asset.add(*command);
  command->add_option("MESH", options->mesh, "The same mesh from somewhere else: glTF, OBJ, PLY, STL or OFF")
      ->required();
  command
      ->add_option("-o,--output", options->out,
                   "CSV file with the point of every vertex, written if all were found")
      ->check(requireName);
  const auto finite = CLI::Validator(
      [](std::string& text) {
        double value = 0.0;
        return CLI::detail::lexical_cast(text, value) && std::isfinite(value) ? std::string()
                                                                              : text + " is not finite";
      },
      "");
  CLI::Option* scale =
      command->add_option("--scale", options->scale, "Length of the mesh's unit in the asset's (default 1)")
          ->check(requirePositive);
  CLI::Option* up = command->add_option("--up", options->up, "The mesh's upward axis, y (default) or z")
                        ->check(CLI::IsMember({"y", "z"}));
  command
      ->add_option("--matrix", options->matrix,
                   "12 numbers, row by row, from the mesh's space to the asset's root space: a similarity")
      ->expected(12)
      ->check(finite)
      ->excludes(scale)
      ->excludes(up);
  command
      ->add_option("--tolerance", options->tolerance,
                   "How far a vertex may be from its place, in the asset's unit (default 0: not at all)")
      ->check(CLI::NonNegativeNumber)
      ->check(finite);
  return [options] { run(*options); };
}

}  // namespace furrow::cli
