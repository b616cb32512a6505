// The whole cook of a skinned sheet of stated size, from file to bytes, on one thread: time, and the peak of
// memory by stage, which Linux alone tells.

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "pipeline/cook/cook.h"
#include "pipeline/heap.h"
#include "pipeline/import/import.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kJoints = 32;

// A GLB file of n x n quads that waves, as exporters write it: normals, UVs and four weights a vertex as
// floats, 52 bytes a vertex. Joints along x; a clip draws them together.
class SheetFile {
 public:
  explicit SheetFile(uint32_t n) : path_(std::filesystem::temp_directory_path() / name(n)) {
    const uint32_t side = n + 1, vertices = side * side;
    std::vector<float> positions, normals, uvs, weights;
    std::vector<uint8_t> joints;
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) {
        const float u = static_cast<float>(x) / static_cast<float>(n),
                    v = static_cast<float>(y) / static_cast<float>(n);
        const float slope = std::cos(20.0f * u) * 0.2f, length = std::sqrt(1.0f + slope * slope);
        positions.insert(positions.end(), {u, v, 0.01f * std::sin(20.0f * u)});
        normals.insert(normals.end(), {-slope / length, 0.0f, 1.0f / length});
        uvs.insert(uvs.end(), {u, 1.0f - v});
        const float at = u * static_cast<float>(kJoints - 4);
        const float joint = std::min(std::floor(at), static_cast<float>(kJoints - 4)), t = at - joint,
                    s = 1.0f - t;
        weights.insert(weights.end(), {s * s * s / 6.0f, (3.0f * t * t * t - 6.0f * t * t + 4.0f) / 6.0f,
                                       (3.0f * s * s * s - 6.0f * s * s + 4.0f) / 6.0f, t * t * t / 6.0f});
        for (int k = 0; k < 4; ++k) joints.push_back(static_cast<uint8_t>(joint) + static_cast<uint8_t>(k));
      }
    std::vector<uint32_t> indices;
    for (uint32_t y = 0; y < n; ++y)
      for (uint32_t x = 0; x < n; ++x) {
        const uint32_t a = y * side + x, c = a + side;
        indices.insert(indices.end(), {a, a + 1, c + 1, a, c + 1, c});
      }
    const std::vector<float> times = {0.0f, 1.0f};
    add(positions, "VEC3", vertices, R"(,"min":[0,0,-0.01],"max":[1,1,0.01])");
    add(normals, "VEC3", vertices);
    add(uvs, "VEC2", vertices);
    add(joints, "VEC4", vertices);
    add(weights, "VEC4", vertices);
    add(indices, "SCALAR", indices.size());
    add(times, "SCALAR", 2, R"(,"min":[0],"max":[1])");
    std::ostringstream nodes, skin, samplers, channels;
    for (uint32_t j = 0; j < kJoints; ++j) {
      const float pull = 0.3f * (0.5f - static_cast<float>(j) / kJoints);
      add(std::vector<float>{0.0f, 0.0f, 0.0f, pull, 0.0f, 0.0f}, "VEC3", 2);
      const char* comma = j ? "," : "";
      nodes << ",{}";
      skin << comma << j + 1;
      samplers << comma << R"({"input":6,"output":)" << 7 + j << "}";
      channels << comma << R"({"sampler":)" << j << R"(,"target":{"node":)" << j + 1
               << R"(,"path":"translation"}})";
    }
    std::ostringstream text;
    text
        << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" << bin_.size() << R"(}],"bufferViews":[)"
        << views_.str() << R"(],"accessors":[)" << accessors_.str()
        << R"(],"meshes":[{"name":"sheet","primitives":[{"attributes":)"
        << R"({"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"JOINTS_0":3,"WEIGHTS_0":4},"indices":5}]}],"nodes":[{"mesh":0,"skin":0})"
        << nodes.str() << R"(],"skins":[{"joints":[)" << skin.str()
        << R"(]}],"animations":[{"name":"squeeze","samplers":[)" << samplers.str() << R"(],"channels":[)"
        << channels.str() << "]}]}";
    std::string json = text.str();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::ofstream file(path_, std::ios::binary);
    const auto words = [&](std::initializer_list<size_t> values) {
      for (const size_t value : values) {
        const auto word = static_cast<uint32_t>(value);
        file.write(reinterpret_cast<const char*>(&word), sizeof word);
      }
    };
    words({0x46546C67, 2, 28 + json.size() + bin_.size(), json.size(), 0x4E4F534A});
    file << json;
    words({bin_.size(), 0x004E4942});
    file.write(bin_.data(), static_cast<std::streamsize>(bin_.size()));
    bin_.clear();
    bin_.shrink_to_fit();
  }
  ~SheetFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  static std::string name(uint32_t n) { return "furrow_sheet_" + std::to_string(n) + ".glb"; }

  template <typename T>
  void add(const std::vector<T>& values, const char* type, size_t count, const char* more = "") {
    const size_t begin = bin_.size(), bytes = values.size() * sizeof(T);
    bin_.append(reinterpret_cast<const char*>(values.data()), bytes);
    const int component = sizeof(T) == 1 ? 5121 : std::is_same_v<T, float> ? 5126 : 5125;
    const char* comma = begin ? "," : "";
    views_ << comma << R"({"buffer":0,"byteOffset":)" << begin << R"(,"byteLength":)" << bytes << "}";
    accessors_ << comma << R"({"bufferView":)" << view_count_++ << R"(,"componentType":)" << component
               << R"(,"count":)" << count << R"(,"type":")" << type << '"' << more << "}";
  }

  std::filesystem::path path_;
  std::string bin_;
  std::ostringstream views_, accessors_;
  size_t view_count_ = 0;
};

// Of this process, in bytes, since resetPeak().
double peak() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024.0 * std::strtod(line.c_str() + 6, nullptr);
  return 0.0;
}

void resetPeak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
}

LayerRecipe layer(const std::string& name) {
  LayerRecipe layer;
  layer.name = name;
  layer.mask = MaskNone{};
  layer.compress = MapNone{};
  return layer;
}

Recipe axis() {
  Recipe recipe;
  recipe.layers = {layer("layer")};
  recipe.layers[0].direction = DirectionAxis{{1.0, 0.0, 0.0}};
  return recipe;
}

Recipe guides() {
  Recipe recipe = axis();
  recipe.layers[0].direction = DirectionGuides{{{{0.5, 0.1, 0.0}, {0.6, 0.5, 0.0}, {0.5, 0.9, 0.0}}}, {}};
  return recipe;
}

Recipe animation() {
  Recipe recipe = axis();
  recipe.layers[0].direction = DirectionAnimation{};
  recipe.layers[0].mask = MaskAuto{};
  return recipe;
}

Recipe twoLayers() {
  Recipe recipe = guides();
  recipe.layers.push_back(recipe.layers[0]);
  recipe.layers[1].name = "other";
  recipe.layers[1].direction = DirectionGuides{{{{0.1, 0.5, 0.0}, {0.9, 0.5, 0.0}}}, {}};
  return recipe;
}

void cookSheet(benchmark::State& state, const Recipe& recipe) {
  keepFreedMemory();
  const SheetFile file(static_cast<uint32_t>(std::sqrt(static_cast<double>(state.range(0)) / 2.0)));
  std::vector<std::pair<std::string, double>> peaks;
  CookReport report;
  for (auto _ : state) {
    peaks.clear();
    resetPeak();
    CookOptions options;
    options.threads = 1;
    std::string stage = "importing";
    const auto next = [&](const char* name) {
      peaks.emplace_back(stage, peak());
      stage = name;
      std::ofstream("/proc/self/clear_refs") << 5;
    };
    options.progress = next;
    report = cook(import(file.path()), recipe, options).report;
    next("");
  }
  const auto triangles = static_cast<double>(report.triangles);
  double most = 0.0;
  for (const auto& [stage, bytes] : peaks) {
    state.counters[stage + ", peak"] = bytes / triangles;
    most = std::max(most, bytes);
  }
  for (const CookStage& stage : report.stages) state.counters[stage.name] = stage.seconds;
  state.counters["bytes a triangle"] = most / triangles;
}

BENCHMARK_CAPTURE(cookSheet, axis, axis())->Arg(250'000)->Arg(1'000'000)->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(cookSheet, guides, guides())->Arg(250'000)->Arg(1'000'000)->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(cookSheet, animation, animation())->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(cookSheet, defaults, defaultRecipe())
    ->Arg(1'000'000)
    ->Arg(4'000'000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(cookSheet, two_layers, twoLayers())->Arg(4'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace furrow::pipeline
