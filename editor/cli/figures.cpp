// furrow_figures FOLDER: what the figures of docs/figures.md are made of that the furrow tool cannot say:
// response.dat and angles.dat for plots, and seam.png. tools/figures.sh makes the figures.

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>

#include "editor/preview/contact_sheet.h"
#include "editor/preview/headless_context.h"
#include "editor/preview/posed_frame.h"
#include "editor/preview/renderer.h"
#include "furrow/jobs.h"
#include "pipeline/cook/cook.h"
#include "pipeline/error.h"
#include "runtime/src/rest_surface.h"

namespace {

using namespace furrow;
using pipeline::Image;

// The runtime's own response, without its answer to stretch: a row an alpha, a column a pair of `curves`.
void writeResponses(const std::filesystem::path& file) {
  constexpr float kCurves[][2] = {{0.8f, 4.0f}, {1.0f, 4.0f}, {1.25f, 4.0f}, {1.0f, 2.0f}, {1.0f, 8.0f}};
  std::ofstream out(file);
  out << "# alpha, then I for (lambda, beta)";
  for (const auto& [lambda, beta] : kCurves) out << " (" << lambda << ", " << beta << ')';
  out << '\n';
  for (int i = 0; i <= 500; ++i) {
    const float alpha = 0.5f + 2.5f * static_cast<float>(i) / 500.0f;
    out << alpha;
    for (const auto& [lambda, beta] : kCurves)
      out << ' ' << respond({Curve::kLarsson, lambda, beta, 1e6f, beta}, 1.0f / alpha, 0.0f, 0.0f);
    out << '\n';
  }
}

// Degrees between a map's normal scaled by I exactly and by z alone (furrowScale, furrowScaleFast), for
// squared lengths of its x and y: blocks of rows "x^2 + y^2, I, degrees".
void writeAngles(const std::filesystem::path& file) {
  std::ofstream out(file);
  out << "# x^2 + y^2, I, degrees\n";
  for (int row = 0; row <= 90; ++row) {
    const double length2 = row * 0.01, z = std::sqrt(1.0 - length2);
    for (int column = 0; column <= 100; ++column) {
      const double I = column * 0.01, x = std::sqrt(length2) * I;
      const double exact = std::atan2(x, z), fast = std::atan2(x, std::sqrt(1.0 - I * I * length2));
      out << length2 << ' ' << I << ' ' << (exact - fast) * 180.0 / std::numbers::pi << '\n';
    }
    out << '\n';
  }
}

// An arm of coarse cloth along x, its UV seam towards the viewer and a little down; the morph target bends it
// upwards in the middle.
constexpr uint32_t kRings = 24, kSpokes = 12;
constexpr double kLength = 4.0, kRadius = 0.6;

glm::dvec3 bent(double x, glm::dvec3 about) {
  constexpr double kAngle = 1.9, kHalf = 0.9;  // radians, and half the length that bends
  const double radius = 2.0 * kHalf / kAngle;
  const double s = std::clamp((x + kHalf) / (2.0 * kHalf), 0.0, 1.0), turn = kAngle * (s - 0.5);
  glm::dvec3 along(std::cos(turn), std::sin(turn), 0.0), up(-std::sin(turn), std::cos(turn), 0.0);
  glm::dvec3 middle(radius * std::sin(turn), radius * (1.0 - std::cos(turn)), 0.0);
  middle += along * (x - (s - 0.5) * 2.0 * kHalf);
  return middle + up * about.y + glm::dvec3(0, 0, about.z);
}

pipeline::SourceScene armScene() {
  pipeline::Primitive arm;
  pipeline::MorphDelta bend;
  for (uint32_t ring = 0; ring <= kRings; ++ring)
    for (uint32_t spoke = 0; spoke <= kSpokes; ++spoke) {
      const double u = static_cast<double>(ring) / kRings, v = static_cast<double>(spoke) / kSpokes;
      // The last spoke lies on the first to the bit.
      const double angle = 2.0 * std::numbers::pi * (spoke % kSpokes) / kSpokes + 0.12 * std::numbers::pi;
      const glm::dvec3 about(0, kRadius * std::sin(angle), kRadius * std::cos(angle));
      const double x = kLength * (u - 0.5);
      const glm::vec3 rest(glm::dvec3(x, 0, 0) + about);
      bend.vertices.push_back(static_cast<uint32_t>(arm.positions.size()));
      bend.positions.push_back(glm::vec3(bent(x, about)) - rest);
      arm.positions.push_back(rest);
      arm.uvs.push_back({static_cast<float>(u), static_cast<float>(v)});
    }
  for (uint32_t ring = 0; ring < kRings; ++ring)
    for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
      const uint32_t a = ring * (kSpokes + 1) + spoke, b = a + 1, c = a + kSpokes + 1, d = c + 1;
      arm.indices.insert(arm.indices.end(), {a, b, c, b, d, c});
    }
  arm.morphs.push_back(std::move(bend));
  pipeline::SourceScene scene;
  scene.file = "arm";
  scene.primitives.push_back(std::move(arm));
  scene.rig.nodes.push_back({});
  scene.rig.palette.push_back({});
  scene.rig.morphs.push_back({"bend", 0, 0, 0.0});
  pipeline::Part part;
  part.mesh = "arm";
  part.material = 0;
  scene.parts.push_back(part);
  pipeline::Material& cloth = scene.materials.emplace_back();
  cloth.name = "cloth";
  cloth.base_color = {0.14f, 0.18f, 0.25f, 1.0f};
  return scene;
}

pipeline::Recipe armRecipe() {
  pipeline::LayerRecipe layer;
  layer.name = "folds";
  layer.direction = pipeline::DirectionAxis{{1, 0, 0}};
  layer.mask = pipeline::MaskNone{};
  layer.response.beta = layer.response.stretch_beta = 3.0f;
  pipeline::MapSynthesized folds;
  folds.preset = pipeline::Preset::kCloth;
  folds.spacing = 0.18;
  folds.depth = 0.055;
  layer.compress = folds;
  pipeline::Recipe recipe;
  recipe.layers.push_back(layer);
  return recipe;
}

// The asset as it would be without the spatial hash: every vertex is a point of its own, and its ring has
// the triangles that name this very vertex.
struct Unwelded {
  explicit Unwelded(const AssetView& welded) : view(welded), own(welded.vertexCount()) {
    std::iota(own.begin(), own.end(), 0u);
    rings = makeRings({view.positions, view.indices, own});
    for (uint32_t point : view.vertex_point)
      for (uint32_t i = 0; i < 4; ++i) directions.push_back(view.layers[0].directions[4 * point + i]);
    layer = view.layers[0];
    layer.directions = directions;
    view.layers = {&layer, 1};
    view.vertex_point = view.point_vertex = own;
    view.surface_indices = view.indices;
    view.ring_offsets = rings.offsets;
    view.ring_triangles = rings.triangles;
    view.ring_weights = rings.weights;
  }

  AssetView view;
  std::vector<uint32_t> own;
  Rings rings;
  std::vector<int8_t> directions;
  Layer layer;
};

Image armPicture(const AssetView& asset, preview::View view) {
  const std::vector<Affine> palette(asset.palette.size());
  const float bend[] = {1.0f};
  FrameInput input;
  input.palette = palette;
  input.morph_weights = bend;
  preview::RenderOptions options;
  options.width = 520;
  options.height = 400;
  options.tier = preview::Tier::kCpu;
  options.view = view;
  options.camera.target = {0.0f, 0.28f, 0.5f};
  options.camera.distance = 2.1f;
  options.camera.yaw = 8.0f;
  return preview::Renderer(asset).render(input, options);
}

void drawSeam(const std::filesystem::path& file) {
  pipeline::CookOptions options;
  options.geometry = pipeline::GeometryCodec::kRaw;
  Asset asset;
  if (const Status status = asset.load(pipeline::cook(armScene(), armRecipe(), options).bytes); !status.ok())
    throw pipeline::Error(pipeline::Exit::kBadData, "arm", status.message, "report it");
  const Unwelded unwelded(asset.view());
  const preview::HeadlessContext context;
  const Image pictures[] = {
      armPicture(asset.view(), preview::View::kBeauty), armPicture(unwelded.view, preview::View::kBeauty),
      armPicture(asset.view(), preview::View::kWeight), armPicture(unwelded.view, preview::View::kWeight)};
  const preview::SheetCell cells[] = {{&pictures[0], "(a) ids from the spatial hash"},
                                      {&pictures[1], "(b) an id a vertex"},
                                      {&pictures[2], "(c) weights of (a)"},
                                      {&pictures[3], "(d) weights of (b)"}};
  preview::SheetLayout layout;
  layout.columns = 2;
  pipeline::writeImage(file, preview::contactSheet(cells, layout));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "furrow_figures: usage: FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  writeResponses(folder / "response.dat");
  writeAngles(folder / "angles.dat");
  drawSeam(folder / "seam.png");
  return 0;
} catch (const furrow::pipeline::Error& error) {
  std::fprintf(stderr, "furrow_figures: %s\n", error.what());
  return static_cast<int>(error.exit());
}
