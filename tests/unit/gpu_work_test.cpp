// What a frame plan's compute shaders touch: every index into a storage buffer is counted while they run, on
// OpenGL. So what is said of work that follows what is active is seen in memory: what is at rest, switched
// off or not due is neither read nor written.

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "furrow/frame_plan.h"
#include "runtime/shaders/layout.h"
#include "sheets.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

// What a dispatch did with one buffer.
struct Touched {
  uint64_t accesses = 0;
  std::vector<bool> words;
  size_t count() const { return static_cast<size_t>(std::count(words.begin(), words.end(), true)); }
};
using Work = std::map<Buffer, Touched>;

size_t wordsOf(const FramePlan& plan, Buffer id) {
  return plan.buffer(id).bytes / sizeof(uint32_t);
}

// Runs a plan with shaders that tell what they touch.
class Recorder {
 public:
  explicit Recorder(const FramePlan& plan) : plan_(plan) {
    for (size_t i = 0; i < kBuffers; ++i) {
      const BufferDesc& desc = plan.buffer(static_cast<Buffer>(i));
      if (desc.bytes == 0) continue;
      glGenBuffers(1, &buffers_[i]);
      glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_[i]);
      const std::vector<std::byte> zeros(desc.bytes);
      glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(desc.bytes),
                   desc.initial.empty() ? zeros.data() : desc.initial.data(), GL_DYNAMIC_DRAW);
      first_word_[i] = tally_words_;
      tally_words_ += 1 + (wordsOf(plan, static_cast<Buffer>(i)) + 31) / 32;
    }
    glGenBuffers(1, &tally_);
    glGenTextures(1, &tally_texels_);
    for (const Item& item : plan.items())
      programs_.push_back(item.kind == ItemKind::kDispatch ? programOf(item) : 0);
  }
  ~Recorder() {
    for (GLuint program : programs_) glDeleteProgram(program);
    glDeleteBuffers(kBuffers, buffers_);
    glDeleteBuffers(1, &tally_);
    glDeleteTextures(1, &tally_texels_);
  }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void write(Buffer id, std::span<const std::byte> bytes, uint32_t instance = 0) {
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_[static_cast<size_t>(id)]);
    glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(instance * plan_.instanceBytes(id)),
                    static_cast<GLsizeiptr>(bytes.size()), bytes.data());
  }

  void write(const FrameInput& input, uint32_t instance = 0) {
    std::vector<std::byte> bytes(plan_.instanceBytes(Buffer::kFrame));
    plan_.writeFrame(input, bytes);
    write(Buffer::kFrame, bytes, instance);
    if (plan_.options().posed_by_host) return;
    bytes.resize(plan_.instanceBytes(Buffer::kMorphWeights));
    plan_.writeMorphWeights(input, bytes);
    write(Buffer::kMorphWeights, bytes, instance);
    write(Buffer::kPalette, std::as_bytes(input.palette), instance);
  }

  // `rows` of the clustered form: how many of kInstances run.
  Work run(uint32_t rows = 1) {
    std::vector<uint32_t> tally(tally_words_);
    glBindBuffer(GL_TEXTURE_BUFFER, tally_);
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(tally.size() * sizeof(uint32_t)), tally.data(),
                 GL_DYNAMIC_DRAW);
    glBindTexture(GL_TEXTURE_BUFFER, tally_texels_);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_R32UI, tally_);
    glBindImageTexture(0, tally_texels_, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    for (size_t i = 0; i < programs_.size(); ++i) {
      const Item& item = plan_.items()[i];
      if (item.kind != ItemKind::kDispatch) {
        glMemoryBarrier(GL_ALL_BARRIER_BITS);
        continue;
      }
      for (const Binding& binding : item.bindings)
        glBindBufferBase(binding.access == Access::kUniform ? GL_UNIFORM_BUFFER : GL_SHADER_STORAGE_BUFFER,
                         binding.slot, buffers_[static_cast<size_t>(binding.buffer)]);
      glUseProgram(programs_[i]);
      glDispatchCompute(item.groups[0], item.shader == Shader::kCluster ? rows : item.groups[1], 1);
    }
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    glGetBufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(tally.size() * sizeof(uint32_t)),
                       tally.data());
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    Work work;
    for (size_t i = 0; i < kBuffers; ++i) {
      if (!buffers_[i]) continue;
      const auto id = static_cast<Buffer>(i);
      work[id] = {tally[first_word_[i]], std::vector<bool>(wordsOf(plan_, id))};
      for (size_t word = 0; word < work[id].words.size(); ++word)
        work[id].words[word] = tally[first_word_[i] + 1 + word / 32] >> word % 32 & 1u;
    }
    return work;
  }

 private:
  static constexpr size_t kBuffers = static_cast<size_t>(Buffer::kCount);

  // The shader's text with every index into a storage buffer counted.
  std::string counting(const Item& item) const {
    std::string text = shaderSource(item.shader).compute;
    const auto closing = [&](size_t at, char open, char close) {
      for (int depth = 0;; ++at) {
        depth += text[at] == open ? 1 : text[at] == close ? -1 : 0;
        if (depth == 0) return at;
      }
    };
    for (const Binding& binding : item.bindings) {
      const auto i = static_cast<size_t>(binding.buffer);
      if (binding.access != Access::kStorage || binding.buffer == Buffer::kFrame || !buffers_[i]) continue;
      const std::string name = binding.name, macro = "FURROW_AT(" + name + ", ",
                        count = "counted(" + std::to_string(first_word_[i]) + "u, ";
      for (size_t at = 0; (at = text.find(macro, at)) != std::string::npos;) {
        const size_t end = closing(at + macro.find('('), '(', ')');
        text[end] = ']';
        text.replace(at, macro.size(), name + "[");
      }
      for (size_t at = 0; (at = text.find(name + "[", at)) != std::string::npos; at += name.size()) {
        if (at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) || text[at - 1] == '_'))
          continue;
        const size_t open = at + name.size();
        text.insert(closing(open, '[', ']'), ")");
        text.insert(open + 1, count);
      }
    }
    const std::string after = "layout(local_size_x = 128) in;";
    text.insert(text.find(after) + after.size(), R"(
layout(r32ui, binding = 0) uniform uimageBuffer tally;
uint counted(uint first, uint index) {
  imageAtomicAdd(tally, int(first), 1u);
  imageAtomicOr(tally, int(first + 1u + index / 32u), 1u << (index % 32u));
  return index;
}
)");
    return text;
  }

  GLuint programOf(const Item& item) const {
    const std::string text = counting(item);
    const char* source = text.c_str();
    const GLuint program = glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &source);
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    char log[512] = {};
    glGetProgramInfoLog(program, sizeof log, nullptr, log);
    EXPECT_TRUE(linked) << item.label << ": " << log;
    return program;
  }

  const FramePlan& plan_;
  GLuint buffers_[kBuffers] = {}, tally_ = 0, tally_texels_ = 0;
  size_t first_word_[kBuffers] = {}, tally_words_ = 0;  // a count of accesses, then a bit a word
  std::vector<GLuint> programs_;
};

// Two sheets beside each other, each with a target of its own; layers of the left, the right and both, and
// one that measures nothing.
Asset sheets() {
  const auto squeeze = [](glm::dvec3 p) { return glm::dvec3(0.8 * p.x, p.y, 0.1 * p.x * p.y); };
  SourceScene scene = sceneOf(sheet(30), squeeze);
  Primitive right = sheet(30);
  for (glm::vec3& p : right.positions) p.x += 2.0f;
  SourceScene other = sceneOf(std::move(right), squeeze);
  scene.primitives.push_back(std::move(other.primitives[0]));
  scene.rig.morphs.push_back({"other", 0, 1, 0.0});
  scene.parts.push_back(other.parts[0]);
  scene.parts[0].mesh = "left";
  scene.parts[1].mesh = "right";
  scene.parts[1].primitive = 1;
  scene.parts[1].first_morph = 1;
  std::vector<pipeline::LayerRecipe> layers;
  for (const char* name : {"left", "right", "both", "none"}) {
    layers.push_back(axisLayer({1, 0, 0}));
    layers.back().name = name;
    if (layers.size() <= 2) layers.back().meshes = {name};
  }
  layers[3].measure = Measure::kNone;
  return cookAsset(std::move(scene), recipeOf(layers));
}

class GpuWork : public GlTest, public testing::WithParamInterface<Form> {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    GLint images = 0;
    if (support_.gpu) glGetIntegerv(GL_MAX_COMPUTE_IMAGE_UNIFORMS, &images);
    if (images == 0) GTEST_SKIP() << support_.reason;
  }

  FrameInput input(float left, float right, uint32_t layers) {
    morphs_ = {left, right};
    FrameInput in;
    in.palette = palette_;
    in.morph_weights = morphs_;
    in.active_layers = layers;
    return in;
  }

  uint64_t accesses(const Work& work) const {
    uint64_t sum = 0;
    for (const auto& [id, touched] : work) sum += touched.accesses;
    return sum;
  }

  const Asset asset_ = sheets();
  const AssetView& view_ = asset_.view();
  const std::vector<Affine> palette_{view_.palette.size()};
  std::vector<float> morphs_;
};

using Range = std::pair<size_t, size_t>;

size_t touchedIn(const Touched& touched, const Range& range) {
  return static_cast<size_t>(std::count(touched.words.begin() + static_cast<ptrdiff_t>(range.first),
                                        touched.words.begin() + static_cast<ptrdiff_t>(range.second), true));
}

// Where the clustered form has what belongs to a morph target, and to a layer.
struct ClusterRanges {
  std::vector<std::vector<Range>> morphs, layers;
  size_t owned_slots = 0;

  explicit ClusterRanges(const FramePlan& plan) {
    const AssetView& asset = plan.asset();
    const auto* table = reinterpret_cast<const uint32_t*>(plan.buffer(Buffer::kClusterTable).initial.data());
    morphs.resize(asset.morphs.size());
    layers.resize(asset.layerCount());
    for (uint32_t i = 0; i < plan.items()[0].groups[0]; ++i) {
      const uint32_t* c = table + size_t{i} * (gpu::kClusterWords + asset.layerCount());
      owned_slots += c[gpu::kClusterVertices];
      for (uint32_t run = c[gpu::kClusterRuns]; run < c[gpu::kClusterRunsEnd]; run += gpu::kRunWords)
        morphs[table[run]].push_back({table[run + 1], table[run + 2]});
      for (uint32_t l = 0; l < asset.layerCount(); ++l)
        if (c[gpu::kClusterCovered] >> l & 1u) {
          const size_t first = c[gpu::kClusterWords + l];
          layers[l].push_back(
              {first, first + size_t{c[gpu::kClusterTriangles]} * coefficientCount(asset.layers[l].measure)});
        }
    }
  }
};

TEST_P(GpuWork, FollowsTheMorphTargetsThatAreActive) {
  const FramePlan plan(view_, {.form = GetParam()});
  ASSERT_EQ(plan.options().form, GetParam());
  Recorder recorder(plan);
  const bool clustered = GetParam() == Form::kClustered;
  for (const auto& active : {std::array{0.0f, 0.0f}, {0.5f, 0.0f}, {0.0f, 0.5f}, {0.5f, 0.5f}}) {
    recorder.write(input(active[0], active[1], 0xfu));
    const Work work = recorder.run();
    if (clustered) {
      const ClusterRanges ranges(plan);
      for (size_t m = 0; m < 2; ++m) {
        EXPECT_GT(ranges.morphs[m].size(), 2u);
        for (const Range& range : ranges.morphs[m])
          EXPECT_EQ(touchedIn(work.at(Buffer::kClusterTable), range),
                    active[m] == 0.0f ? 0u : range.second - range.first);
      }
    } else {  // every vertex looks which targets have entries of it
      size_t entries = 0;
      for (size_t m = 0; m < 2; ++m)
        entries += (active[m] == 0.0f ? 1u : 4u) * view_.morphs[m].vertices.size();
      EXPECT_EQ(work.at(Buffer::kMorphEntries).count(), view_.vertexCount() + 1 + entries);
    }
  }
}

TEST_P(GpuWork, FollowsTheLayersThatAreActive) {
  const FramePlan plan(view_, {.form = GetParam()});
  Recorder recorder(plan);
  const auto run = [&](uint32_t layers) {
    recorder.write(input(0.5f, 0.5f, layers));
    return recorder.run();
  };
  const bool clustered = GetParam() == Form::kClustered;
  for (uint32_t layers = 0; layers < 16; ++layers) {
    const Work work = run(layers);
    EXPECT_EQ(work.at(Buffer::kWeights).count(), wordsOf(plan, Buffer::kWeights));
    for (uint32_t l = 0; l < 4; ++l) {
      const bool active = (layers >> l & 1u) != 0;
      SCOPED_TRACE(testing::Message() << view_.layers[l].name << " of layers " << layers);
      if (clustered) {
        const ClusterRanges ranges(plan);
        EXPECT_EQ(ranges.layers[l].empty(), l == 3);
        for (const Range& range : ranges.layers[l])
          EXPECT_EQ(touchedIn(work.at(Buffer::kClusterData), range),
                    active ? range.second - range.first : 0u);
      } else {
        const size_t triangles = view_.triangleCount(), points = view_.pointCount();
        EXPECT_EQ(touchedIn(work.at(Buffer::kTriangleQ), {l * triangles, (l + 1) * triangles}),
                  active ? triangles : 0u);
        EXPECT_EQ(touchedIn(work.at(Buffer::kPointQ), {l * points, (l + 1) * points}), active ? points : 0u);
        const size_t first = 2 * l * triangles;
        const size_t coefficients = l < 3 ? 2 * triangles : 0;
        EXPECT_EQ(touchedIn(work.at(Buffer::kCoefficients), {first, first + coefficients}),
                  active ? coefficients : 0u);
      }
    }
  }
  if (!clustered) return;
  // What a layer costs is its own: as much as it covers, beside whatever others.
  const auto none = accesses(run(0)), left = accesses(run(1)) - none, right = accesses(run(2)) - none,
             both = accesses(run(4)) - none;
  EXPECT_LT(both, 1.02 * static_cast<double>(left + right));
  EXPECT_GT(both, 0.98 * static_cast<double>(left + right));
  EXPECT_LE(accesses(run(7)), none + left + right + both);
  // Where nothing is measured, no cluster looks at its halo.
  const Work still = run(0);
  EXPECT_EQ(ClusterRanges(plan).owned_slots, view_.vertexCount());
  EXPECT_EQ(still.at(Buffer::kRestVertices).accesses, uint64_t{10} * view_.vertexCount());
  EXPECT_EQ(still.at(Buffer::kInfluences).accesses, uint64_t{view_.influences} * view_.vertexCount());
}

class ClusteredGpuWork : public GpuWork {};

TEST_P(ClusteredGpuWork, ReadsPosedVerticesWhereALayerMeasures) {
  const FramePlan plan(view_, {.form = GetParam(), .posed_by_host = true});
  Recorder recorder(plan);
  recorder.write(Buffer::kPositions, std::as_bytes(view_.positions));
  recorder.write(input(0.0f, 0.0f, 0u));
  EXPECT_EQ(recorder.run().at(Buffer::kPositions).accesses, 0u);
  recorder.write(input(0.0f, 0.0f, 1u));
  const Work work = recorder.run();
  for (size_t part = 0; part < 2; ++part) {
    const Range words = {size_t{3} * view_.parts[part].vertex_begin,
                         size_t{3} * view_.parts[part].vertex_end};
    const size_t touched = touchedIn(work.at(Buffer::kPositions), words);
    if (part == 0) {
      EXPECT_EQ(touched, words.second - words.first);
    } else {  // of the clusters that reach over
      EXPECT_LT(touched, (words.second - words.first) / 2);
    }
  }
}

TEST_P(ClusteredGpuWork, FollowsTheInstancesThatAreDue) {
  const FramePlan plan(view_, {.normals = true, .ease = true, .instances = 5});
  Recorder recorder(plan);
  for (uint32_t i = 0; i < 5; ++i) recorder.write(input(0.5f, 0.0f, 0xfu), i);
  const std::vector<uint32_t> due = {3, 1};
  recorder.write(Buffer::kInstances, std::as_bytes(std::span(due)));
  const Work two = recorder.run(2), one = recorder.run(1);
  EXPECT_EQ(accesses(two), 2 * accesses(one));
  for (Buffer id : {Buffer::kPalette, Buffer::kMorphWeights, Buffer::kPositions, Buffer::kNormals,
                    Buffer::kTangents, Buffer::kState, Buffer::kWeights}) {
    const size_t each = plan.instanceBytes(id) / sizeof(uint32_t);
    for (size_t i = 0; i < 5; ++i)
      EXPECT_EQ(touchedIn(two.at(id), {i * each, (i + 1) * each}) > 0, i == 1 || i == 3)
          << plan.buffer(id).name << " of instance " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Clustered, GpuWork, testing::Values(Form::kClustered));
INSTANTIATE_TEST_SUITE_P(Clustered, ClusteredGpuWork, testing::Values(Form::kClustered));
INSTANTIATE_TEST_SUITE_P(Staged, GpuWork, testing::Values(Form::kStaged));

}  // namespace
}  // namespace furrow::tests
