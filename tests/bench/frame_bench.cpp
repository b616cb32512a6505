// Frames of the cpu tier beside what they are held against, as JSON on stdout. `frame_bench [ROUNDS]`.
//
// All forms of a frame are timed in turn, ROUNDS times; each time it is run once to warm up and then in
// pieces, in frame order. What counts is the sum of the least times of the pieces, so that a neighbour who
// takes the processor for a moment does not.

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <thread>

#include "../unit/sheets.h"
#include "eigen_reference.h"
#include "furrow/cluster_frame.h"
#include "staged_reference.h"

namespace {

using namespace furrow;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr uint32_t kPieces = 32;
constexpr uint32_t kJoints = 98;

double seconds(Clock::time_point since) {
  return std::chrono::duration<double>(Clock::now() - since).count();
}

// One way of doing something, in pieces.
struct Form {
  Form(std::string form_name, std::vector<std::function<void()>> form_pieces)
      : name(std::move(form_name)), pieces(std::move(form_pieces)), least(pieces.size(), 1e9) {}
  std::string name;
  std::vector<std::function<void()>> pieces;
  std::vector<double> least;
  double time() const { return std::accumulate(least.begin(), least.end(), 0.0); }
};

// run(begin, end) over `count` items.
template <typename Run>
std::vector<std::function<void()>> pieces(uint32_t count, Run run) {
  std::vector<std::function<void()>> out;
  for (uint64_t i = 0; i < kPieces; ++i)
    out.push_back([=] {
      run(static_cast<uint32_t>(count * i / kPieces), static_cast<uint32_t>(count * (i + 1) / kPieces));
    });
  return out;
}

void time(std::vector<Form>& forms, int rounds) {
  for (int round = 0; round < rounds; ++round)
    for (Form& form : forms) {
      for (const auto& piece : form.pieces) piece();
      for (size_t i = 0; i < form.pieces.size(); ++i) {
        const auto start = Clock::now();
        form.pieces[i]();
        form.least[i] = std::min(form.least[i], seconds(start));
      }
    }
}

// The same from memory: before each form all caches are filled with something else.
void timeCold(std::vector<Form>& forms, int rounds) {
  std::vector<char> other(size_t{96} << 20);
  for (int round = 0; round < rounds; ++round)
    for (Form& form : forms) {
      std::fill(other.begin(), other.end(), static_cast<char>(round));
      for (size_t i = 0; i < form.pieces.size(); ++i) {
        const auto start = Clock::now();
        form.pieces[i]();
        form.least[i] = std::min(form.least[i], seconds(start));
      }
    }
}

json timesOf(const std::vector<Form>& forms) {
  json out;
  for (const Form& form : forms) out[form.name] = form.time();
  return out;
}

std::vector<Simd> available() {
  std::vector<Simd> all;
  for (Simd simd : {Simd::kPortable, Simd::kSse4, Simd::kAvx2, Simd::kAvx512, Simd::kNeon})
    if (simdAvailable(simd)) all.push_back(simd);
  return all;
}

// A sheet of side x side quads on a chain of joints, four to a vertex.
pipeline::SourceScene skinned(uint32_t side) {
  pipeline::SourceScene scene = tests::sceneOf(tests::sheet(side), [](glm::dvec3 p) { return p; });
  pipeline::Primitive& primitive = scene.primitives[0];
  primitive.morphs.clear();
  scene.rig.morphs.clear();
  scene.rig.palette.assign(kJoints, {});
  scene.parts[0].skinned = true;
  scene.parts[0].palette_count = kJoints;
  primitive.influences = 4;
  for (const glm::vec3& p : primitive.positions) {
    const auto first = static_cast<uint16_t>(p.x * static_cast<float>(kJoints - 4));
    for (uint16_t k = 0; k < 4; ++k) primitive.joints.push_back(first + k);
    for (float w : {0.4f, 0.3f, 0.2f, 0.1f}) primitive.weights.push_back(w);
  }
  return scene;
}

// The same surface with its vertices and triangles in random order.
void shuffle(pipeline::Primitive& p) {
  std::mt19937 random(1);
  std::vector<uint32_t> to(p.positions.size());
  std::iota(to.begin(), to.end(), 0u);
  std::shuffle(to.begin(), to.end(), random);
  pipeline::Primitive out = p;
  for (size_t v = 0; v < to.size(); ++v) {
    out.positions[to[v]] = p.positions[v];
    out.uvs[to[v]] = p.uvs[v];
    for (uint32_t k = 0; k < p.influences; ++k) {
      out.joints[size_t{to[v]} * p.influences + k] = p.joints[v * p.influences + k];
      out.weights[size_t{to[v]} * p.influences + k] = p.weights[v * p.influences + k];
    }
  }
  std::vector<uint32_t> triangles(p.indices.size() / 3);
  std::iota(triangles.begin(), triangles.end(), 0u);
  std::shuffle(triangles.begin(), triangles.end(), random);
  for (size_t i = 0; i < triangles.size(); ++i)
    for (size_t k = 0; k < 3; ++k) out.indices[3 * i + k] = to[p.indices[3 * size_t{triangles[i]} + k]];
  p = std::move(out);
}

pipeline::LayerRecipe layerOf(const std::string& name, Measure measure, double angle) {
  pipeline::LayerRecipe layer = tests::axisLayer({std::cos(angle), std::sin(angle), 0.0});
  layer.name = name;
  layer.measure = measure;
  return layer;
}

pipeline::Recipe layers(uint32_t count, Measure measure = Measure::kDirectional) {
  std::vector<pipeline::LayerRecipe> all;
  for (uint32_t l = 0; l < count; ++l)
    all.push_back(layerOf(std::string(1, static_cast<char>('a' + l)), measure, 0.4 * l));
  pipeline::Recipe recipe = tests::recipeOf(std::move(all));
  for (pipeline::LayerRecipe& layer : recipe.layers) layer.response.curve = Curve::kLarsson;
  return recipe;
}

// An asset, what a frame of it needs, and where its results go.
struct Character {
  Character(pipeline::SourceScene scene, const pipeline::Recipe& recipe)
      : asset(tests::cookAsset(std::move(scene), recipe)), view(asset.view()) {
    if (!clusters.build(view).ok()) std::abort();
    palette.resize(view.palette.size());
    for (size_t i = 0; i < palette.size(); ++i) {
      palette[i].m[3] = -0.004f * static_cast<float>(i);  // squeezes along x
      palette[i].m[7] = 0.001f * static_cast<float>(i);
    }
    morph_weights.resize(view.morphs.size());
    positions.resize(view.vertexCount());
    normals.resize(view.vertexCount());
    tangents.resize(view.vertexCount());
    weights.resize(size_t{view.vertexCount()} * view.weightStride());
    scratch.resize(clusters.scratchBytes() + 64);
    deform(bestSimd(), false).run(0, view.vertexCount());
  }

  DeformJob deform(Simd simd, bool frames) {
    DeformJob job{&view, palette, morph_weights, positions, {}, {}};
    if (frames) job.normals = normals, job.tangents = tangents;
    job.simd = simd;
    return job;
  }
  ClusterFrameJob frame(Simd simd, bool posed) {
    ClusterFrameJob job;
    job.clusters = &clusters;
    if (posed) job.posed = reinterpret_cast<const std::byte*>(positions.data());
    job.palette = palette;
    job.morph_weights = morph_weights;
    job.weights = weights;
    job.simd = simd;
    if (!job.validate().ok()) std::abort();
    return job;
  }
  std::span<std::byte> memory() {
    const size_t off = 64 - (reinterpret_cast<uintptr_t>(scratch.data()) & 63);
    return {scratch.data() + off, clusters.scratchBytes()};
  }
  Form form(std::string name, Simd simd, bool posed) {
    return {std::move(name),
            pieces(clusters.count(), [this, job = frame(simd, posed)](uint32_t begin, uint32_t end) {
              job.run(begin, end, memory());
            })};
  }

  Asset asset;
  const AssetView& view;
  Clusters clusters;
  std::vector<Affine> palette;
  std::vector<float> morph_weights;
  std::vector<Float3> positions, normals;
  std::vector<Float4> tangents;
  std::vector<int16_t> weights;
  std::vector<std::byte> scratch;
};

// What a host can do for the tables of large meshes, here that of the clusters: pages of 2 MiB.
class LargePages final : public std::pmr::memory_resource {
  static constexpr size_t kPage = size_t{2} << 20;
  void* do_allocate(size_t bytes, size_t) override {
    const size_t whole = (bytes + kPage - 1) / kPage * kPage;
    void* memory = ::operator new(whole, std::align_val_t(kPage));
#ifdef __linux__
    madvise(memory, whole, MADV_HUGEPAGE);
#endif
    return memory;
  }
  void do_deallocate(void* memory, size_t, size_t) override {
    ::operator delete(memory, std::align_val_t(kPage));
  }
  bool do_is_equal(const memory_resource& other) const noexcept override {
    return this == &other;
  }
};

// What no frame can do without: the ring gather alone, as Eigen's product of a sparse matrix and a vector.
struct EigenRings {
  explicit EigenRings(const AssetView& asset)
      : rings(asset.pointCount(), asset.triangleCount()),
        triangle_q(Eigen::VectorXf::Ones(asset.triangleCount())),
        q(asset.pointCount()) {
    std::vector<Eigen::Triplet<float>> entries;
    for (uint32_t p = 0; p < asset.pointCount(); ++p)
      for (uint32_t i = asset.ring_offsets[p]; i < asset.ring_offsets[p + 1]; ++i)
        entries.emplace_back(p, asset.ring_triangles[i],
                             static_cast<float>(asset.ring_weights[i]) / 65535.0f);
    rings.setFromTriplets(entries.begin(), entries.end());
  }
  Form form() {
    return {"eigen", pieces(static_cast<uint32_t>(rings.rows()), [this](uint32_t begin, uint32_t end) {
              bench::gather(rings, triangle_q, begin, end, q);
            })};
  }
  Eigen::SparseMatrix<float, Eigen::RowMajor> rings;
  Eigen::VectorXf triangle_q, q;
};

// A memcpy of `bytes`.
struct Copy {
  explicit Copy(uint64_t bytes) : from(bytes, 1), to(bytes) {}
  Form form() {
    return {"copy", pieces(static_cast<uint32_t>(from.size()), [this](uint32_t begin, uint32_t end) {
              std::memcpy(&to[begin], &from[begin], end - begin);
            })};
  }
  std::vector<char> from, to;
};

// A frame whose halves two threads do, in pieces that begin at once and end when both are done.
double twoThreads(Character& character, int rounds) {
  const ClusterFrameJob job = character.frame(bestSimd(), false);
  const uint32_t count = character.clusters.count();
  std::vector<std::byte> other(character.scratch.size());
  const std::span other_memory(other.data() + 64 - (reinterpret_cast<uintptr_t>(other.data()) & 63),
                               character.clusters.scratchBytes());
  const auto piece = [&](uint32_t i, std::span<std::byte> memory) {
    job.run(count * i / (2 * kPieces), count * (i + 1) / (2 * kPieces), memory);
  };
  std::atomic<uint32_t> begun = 0, done = 0;
  const uint32_t steps = static_cast<uint32_t>(rounds) * kPieces;
  std::thread second([&] {
    for (uint32_t step = 0; step < steps; ++step) {
      while (begun <= step) {
      }
      piece(kPieces + step % kPieces, other_memory);
      done = step + 1;
    }
  });
  std::vector<double> least(kPieces, 1e9);
  for (uint32_t step = 0; step < steps; ++step) {
    const auto start = Clock::now();
    begun = step + 1;
    piece(step % kPieces, character.memory());
    while (done <= step) {
    }
    least[step % kPieces] = std::min(least[step % kPieces], seconds(start));
  }
  second.join();
  return std::accumulate(least.begin(), least.end(), 0.0);
}

json frames(uint32_t side, int rounds) {
  Character character(skinned(side), layers(1));
  EigenRings eigen(character.view);
  bench::StagedReference staged(character.view);
  std::vector<Form> forms = {eigen.form()};
  std::vector<std::function<void()>> stages;
  for (auto& stage :
       {pieces(staged.vertices(), [&](uint32_t b, uint32_t e) { staged.skin(character.palette, b, e); }),
        pieces(staged.triangles(), [&](uint32_t b, uint32_t e) { staged.measure(b, e); }),
        pieces(staged.points(), [&](uint32_t b, uint32_t e) { staged.gather(b, e); })})
    stages.insert(stages.end(), stage.begin(), stage.end());
  forms.emplace_back("staged", stages);
  for (Simd simd : available()) {
    forms.push_back(character.form(std::string("posed ") + simdName(simd), simd, true));
    forms.push_back(character.form(std::string("whole ") + simdName(simd), simd, false));
    forms.emplace_back(std::string("skin ") + simdName(simd),
                       pieces(character.view.vertexCount(), [job = character.deform(simd, true)](
                                                                uint32_t b, uint32_t e) { job.run(b, e); }));
  }
  Character shuffled(
      [&] {
        pipeline::SourceScene scene = skinned(side);
        shuffle(scene.primitives[0]);
        return scene;
      }(),
      layers(1));
  forms.push_back(shuffled.form("shuffled", bestSimd(), false));
  LargePages large_pages;
  Clusters large(&large_pages);
  if (!large.build(character.view).ok()) std::abort();
  ClusterFrameJob large_job = character.frame(bestSimd(), true);
  large_job.clusters = &large;
  forms.emplace_back("large pages", pieces(large.count(), [&](uint32_t begin, uint32_t end) {
                       large_job.run(begin, end, character.memory());
                     }));
  time(forms, rounds);

  // The reference must do the same work: its weights agree to the rounding of its sums.
  for (uint32_t v = 0; v < character.view.vertexCount(); ++v)
    if (std::abs(staged.weights()[character.view.vertex_point[v]] - character.weights[size_t{2} * v]) > 8) {
      std::fprintf(stderr, "frame_bench: the staged reference disagrees\n");
      std::exit(1);
    }

  const uint32_t count = character.clusters.count();
  return {{"triangles", character.view.triangleCount()},
          {"vertices", character.view.vertexCount()},
          {"clusters", count},
          {"times", timesOf(forms)},
          {"two threads", twoThreads(character, 2 * rounds)},
          {"bytes",
           {{"whole", character.clusters.frameBytes(false)},
            {"posed", character.clusters.frameBytes(true)},
            {"staged", staged.bytes()}}}};
}

json measuresAndLayers(uint32_t side, int rounds) {
  Character one(skinned(side), layers(1)), area(skinned(side), layers(1, Measure::kArea)),
      principal(skinned(side), layers(1, Measure::kPrincipal)), two(skinned(side), layers(2)),
      three(skinned(side), layers(3)), four(skinned(side), layers(4)), eight(skinned(side), layers(8));
  std::vector<Form> forms;
  for (bool posed : {true, false})
    for (Simd simd : {bestSimd(), std::min(bestSimd(), Simd::kAvx2)}) {
      const std::string after = std::string(posed ? " posed " : " whole ") + simdName(simd);
      if (!forms.empty() && forms.back().name == "8" + after) continue;
      forms.push_back(area.form("area" + after, simd, posed));
      forms.push_back(principal.form("principal" + after, simd, posed));
      forms.push_back(one.form("1" + after, simd, posed));
      forms.push_back(two.form("2" + after, simd, posed));
      forms.push_back(three.form("3" + after, simd, posed));
      forms.push_back(four.form("4" + after, simd, posed));
      forms.push_back(eight.form("8" + after, simd, posed));
    }
  time(forms, rounds);
  return {{"triangles", one.view.triangleCount()}, {"times", timesOf(forms)}};
}

// 180,000 triangles, 98 bones, four influences, 50 morph targets of which 5 are active, each moving a fifth
// of the vertices.
json dawn(int rounds) {
  constexpr uint32_t kMorphs = 50, kActive = 5;
  pipeline::SourceScene scene = skinned(300);
  pipeline::Primitive& primitive = scene.primitives[0];
  for (uint32_t m = 0; m < kMorphs; ++m) {
    pipeline::MorphDelta delta;
    const glm::vec2 center(0.1f + 0.8f * static_cast<float>(m % 10) / 9.0f,
                           0.1f + 0.8f * static_cast<float>(m / 10) / 4.0f);
    for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
      const float r = glm::distance(glm::vec2(primitive.positions[v]), center);
      if (r > 0.25f) continue;
      delta.vertices.push_back(v);
      delta.positions.push_back(glm::vec3(0.0f, 0.0f, 0.1f * (0.25f - r)));
    }
    primitive.morphs.push_back(std::move(delta));
    scene.rig.morphs.push_back({"target" + std::to_string(m), 0, m, 0.0});
  }
  Character character(std::move(scene), layers(1));
  uint64_t moved = 0;
  for (uint32_t m = 0; m < kActive; ++m) {
    character.morph_weights[m * kMorphs / kActive] = 0.7f;
    moved += character.view.morphs[m * kMorphs / kActive].vertices.size();
  }
  // A target's vertex: its slot, which of the target's it is, three words of displacement.
  const uint64_t bytes = character.clusters.frameBytes(false) + moved * (2 + 4 + 12) +
                         character.palette.size() * sizeof(Affine) +
                         character.positions.size() * sizeof(Float3);
  Copy copy(bytes);
  std::vector<Form> forms = {copy.form()};
  for (Simd simd : {bestSimd(), std::min(bestSimd(), Simd::kAvx2)}) {
    ClusterFrameJob job = character.frame(simd, false);
    job.positions = character.positions;
    forms.emplace_back(std::string("whole ") + simdName(simd),
                       pieces(character.clusters.count(), [&character, job](uint32_t b, uint32_t e) {
                         job.run(b, e, character.memory());
                       }));
    std::vector<std::function<void()>> both =
        pieces(character.view.vertexCount(),
               [job = character.deform(simd, true)](uint32_t b, uint32_t e) { job.run(b, e); });
    for (auto& piece : character.form("", simd, true).pieces) both.push_back(piece);
    forms.emplace_back(std::string("with normals and tangents ") + simdName(simd), both);
  }
  std::vector<Form> cold = forms;
  time(forms, rounds);
  timeCold(cold, (rounds + 3) / 4);
  return {{"triangles", character.view.triangleCount()},
          {"vertices", character.view.vertexCount()},
          {"moved", moved},
          {"bytes", bytes},
          {"times", timesOf(forms)},
          {"cold", timesOf(cold)}};
}

// Bytes a second that one thread reads from memory.
double readBandwidth() {
  std::vector<uint64_t> words(size_t{32} << 20, 1);
  double best = 0.0;
  uint64_t total = 0;
  for (int round = 0; round < 8; ++round)
    for (size_t first = 0; first < words.size(); first += words.size() / 64) {
      uint64_t sums[8] = {};
      const auto start = Clock::now();
      for (size_t i = first; i < first + words.size() / 64; i += 8)
        for (size_t k = 0; k < 8; ++k) sums[k] += words[i + k];
      const double rate = static_cast<double>(words.size() / 64 * 8) / seconds(start);
      total += std::accumulate(sums, sums + 8, uint64_t{0});
      best = std::max(best, rate);
    }
  return total > 0 ? best : 0.0;  // so that the sums are wanted
}

json loading(uint32_t side) {
  pipeline::CookOptions options;
  const pipeline::Cooked cooked = pipeline::cook(skinned(side), layers(1), options);
  double load = 1e9, build = 1e9;
  for (int round = 0; round < 5; ++round) {
    Asset asset;
    auto start = Clock::now();
    if (!asset.load(cooked.bytes).ok()) std::abort();
    load = std::min(load, seconds(start));
    Clusters clusters;
    start = Clock::now();
    if (!clusters.build(asset.view()).ok()) std::abort();
    build = std::min(build, seconds(start));
  }
  return {{"load", load}, {"build", build}, {"file", cooked.bytes.size()}};
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 60;
  json out;
  out["best"] = simdName(bestSimd());
  out["read_bandwidth"] = readBandwidth();
  out["frames"] = {frames(222, 4 * rounds), frames(707, rounds)};
  out["layers"] = measuresAndLayers(222, 2 * rounds);
  out["dawn"] = dawn(2 * rounds);
  out["loading"] = loading(222);
  std::printf("%s\n", out.dump(1).c_str());
}
