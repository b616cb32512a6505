#include "pipeline/import/sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/scene/posing.h"
#include "pipeline/scene/rest.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::pipeline {
namespace {

using test::GltfBuilder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const char* const kFaces = "f 1 2 3 4\nf 2 5 6 3\n";

class SequenceTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return folder_.path() / name;
  }

  // Two squares in a row, the whole scaled by `width` along x and moved by `x`.
  std::filesystem::path strip(const std::string& name, double width, double x = 0.0,
                              const std::string& faces = kFaces) const {
    std::string text;
    for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}})
      text += "v " + std::to_string(x + width * u) + " " + std::to_string(v) + " 0\n";
    return write(name, text + faces);
  }

  std::filesystem::path pattern(const std::string& name) const { return folder_.path() / name; }

 private:
  test::ScratchFolder folder_;
};

template <typename Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    EXPECT_EQ(e.exit(), Exit::kBadData) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "was not refused";
  return {};
}

// Positions of the first part in the clip.
std::vector<glm::dvec3> at(const SourceScene& scene, double time) {
  Pose pose = defaultPose(scene.rig);
  applyClip(scene.rig, scene.rig.clips.at(0), time, pose);
  return posePart(scene, scene.parts[0], evaluate(scene.rig, pose));
}

TEST_F(SequenceTest, NumbersAreSortedByValue) {
  for (const char* name :
       {"f_10.obj", "f_9.obj", "f_009b.obj", "f_2.obj", "f_100.obj", "f_2_3.obj", "g_1.obj"})
    strip(name, 1.0);
  std::vector<std::string> names;
  for (const auto& file : sequenceFiles(pattern("f_*.obj"))) names.push_back(file.stem());
  EXPECT_THAT(names, ElementsAre("f_2", "f_2_3", "f_9", "f_009b", "f_10", "f_100"));
  EXPECT_EQ(sequenceFiles(pattern("?_1.obj")).size(), 1u);
  EXPECT_TRUE(sequenceFiles(pattern("nowhere/f_*.obj")).empty());
}

TEST_F(SequenceTest, BecomesAClipThatMeetsEveryFrame) {
  strip("f1.obj", 1.0);
  strip("f2.obj", 0.5);
  strip("f10.obj", 2.0);
  const SourceScene scene = importSequence({pattern("f*.obj"), {}, 4.0});
  EXPECT_TRUE(scene.sequence);
  EXPECT_EQ(scene.file.filename(), "f1.obj");
  EXPECT_EQ(scene.dependencies.size(), 3u);
  ASSERT_EQ(scene.rig.clips.size(), 1u);
  EXPECT_EQ(scene.rig.clips[0].name, "sequence");
  EXPECT_EQ(scene.rig.clips[0].duration, 0.5);
  ASSERT_EQ(scene.rig.morphs.size(), 3u);
  EXPECT_EQ(scene.rig.morphs[2].name, "f10");
  for (const auto& [time, width] :
       {std::pair{0.0, 1.0}, {0.25, 0.5}, {0.5, 2.0}, {0.375, 1.25}, {9.0, 2.0}}) {
    SCOPED_TRACE(time);
    EXPECT_NEAR(at(scene, time)[4].x, 2.0 * width, 1e-6);
    EXPECT_NEAR(at(scene, time)[5].y, 1.0, 1e-6);
  }
}

TEST_F(SequenceTest, TheBaseBringsSeamsAndMaterials) {
  strip("f1.obj", 0.5);
  strip("f2.obj", 2.0);
  const auto base =
      write("base.obj",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
            "usemtl a\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 2/1 5/2 6/3 3/4\n");
  const SourceScene scene = importSequence({pattern("f?.obj"), base, 24.0});
  ASSERT_EQ(scene.parts.size(), 2u);
  EXPECT_FALSE(scene.primitives[1].uvs.empty());
  EXPECT_EQ(scene.dependencies.size(), 3u);
  Pose pose = defaultPose(scene.rig);
  EXPECT_NEAR(posePart(scene, scene.parts[1], evaluate(scene.rig, pose))[2].x, 2.0, 1e-6);
  applyClip(scene.rig, scene.rig.clips[0], 1.0 / 24.0, pose);
  EXPECT_NEAR(posePart(scene, scene.parts[1], evaluate(scene.rig, pose))[2].x, 4.0, 1e-6);
}

// Deltas have 16 bits: what travels far moves with its node.
TEST_F(SequenceTest, TravelMovesTheNode) {
  strip("f1.obj", 1.0);
  strip("f2.obj", 0.5, 1000.0);
  const SourceScene scene = importSequence({pattern("f?.obj"), {}, 1.0});
  EXPECT_NEAR(at(scene, 1.0)[4].x, 1001.0, 1e-3);
  for (const glm::vec3& delta : scene.primitives[0].morphs[1].positions) EXPECT_LT(glm::length(delta), 2.0f);
}

TEST_F(SequenceTest, NormalsFollowTheFaces) {
  strip("f1.obj", 1.0);
  write("f2.obj", std::string("v 0 0 0\nv 0 0 1\nv 0 1 1\nv 0 1 0\nv 0 0 2\nv 0 1 2\n") + kFaces);
  const SourceScene scene = importSequence({pattern("f?.obj"), {}, 1.0});
  const MorphDelta& delta = scene.primitives[0].morphs[1];
  ASSERT_EQ(delta.normals.size(), 6u);
  for (const glm::vec3& n : delta.normals)
    EXPECT_LT(glm::distance(glm::vec3(0, 0, 1) + n, glm::vec3(-1, 0, 0)), 1e-6f);
}

TEST_F(SequenceTest, SaysWhichFrameDiffersAndHow) {
  strip("f1.obj", 1.0);
  strip("f2.obj", 1.0);
  const auto refused = [&] { return refusal([&] { importSequence({pattern("f?.obj"), {}, 24.0}); }); };
  strip("f3.obj", 1.0, 0.0, "f 1 2 3 4\nf 2 5 6\n");
  EXPECT_THAT(refused(), ::testing::AllOf(HasSubstr("f3.obj: its face 2"), HasSubstr("f1.obj")));
  strip("f3.obj", 1.0, 0.0, "f 1 2 3 4\n");
  EXPECT_THAT(refused(), HasSubstr("f3.obj: it has 1 faces and f1.obj has 2"));
  strip("f3.obj", 1.0, 0.0, std::string("v 9 9 9\n") + kFaces);
  EXPECT_THAT(refused(), HasSubstr("f3.obj: it has 7 vertices and f1.obj has 6"));
  write("f3.obj", "nothing");
  EXPECT_THAT(refused(), HasSubstr("f3.obj: it has no faces"));
  EXPECT_THAT(refusal([&] { importSequence({pattern("none_*.obj"), {}, 24.0}); }), HasSubstr("no file"));
  GltfBuilder gltf;
  write("g.glb", gltf.glb(""));
  EXPECT_THAT(refusal([&] { importSequence({pattern("*.glb"), {}, 24.0}); }), HasSubstr("glTF"));
}

class RestFileTest : public SequenceTest {
 protected:
  std::vector<glm::dvec3> offsets(const std::filesystem::path& source,
                                  const std::filesystem::path& rest) const {
    return restOffsets(import(source), import(rest));
  }
};

TEST_F(RestFileTest, VerticesCorrespondByTheirOrder) {
  // The source has a UV seam, so that its third vertex of the file comes twice.
  const auto source =
      write("source.obj",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
            "f 1/1 2/2 3/3 4/4\nf 2/1 5/2 6/3 3/4\n");
  const auto rest = strip("rest.obj", 1.5, 0.0, "f 1 2 3 4\nf 5 6 3 2\n");
  const SourceScene scene = import(source);
  const std::vector<glm::dvec3> moved = restOffsets(scene, import(rest));
  ASSERT_EQ(moved.size(), 8u);
  for (size_t v = 0; v < moved.size(); ++v)
    EXPECT_NEAR(moved[v].x, 0.5 * static_cast<double>(scene.primitives[0].positions[v].x), 1e-6);
}

TEST_F(RestFileTest, GltfTakesAnObjInItsSourceOrder) {
  GltfBuilder file;
  file.add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
  file.add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 1);
  const auto source =
      write("source.glb", file.glb(R"("nodes":[{"mesh":0,"translation":[5,0,0]}],"scenes":[{"nodes":[0]}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])"));
  const auto rest = write("rest.obj", "v 5 0 0\nv 7 0 0\nv 7 1 0\nv 5 1 0\nf 1 2 3\nf 1 3 4\n");
  const std::vector<glm::dvec3> moved = offsets(source, rest);
  ASSERT_EQ(moved.size(), 4u);
  EXPECT_NEAR(glm::distance(moved[2], glm::dvec3(1, 0, 0)), 0.0, 1e-6);
  EXPECT_NEAR(glm::length(moved[3]), 0.0, 1e-6);
}

TEST_F(RestFileTest, SaysWhatDiffers) {
  const auto source = strip("source.obj", 1.0);
  const auto refused = [&](const std::filesystem::path& rest) {
    return refusal([&] { offsets(source, rest); });
  };
  EXPECT_THAT(refused(strip("more.obj", 1.0, 0.0, "v 9 9 9\nf 1 2 3 4\nf 2 5 7 6 3\n")),
              HasSubstr("more.obj: it has 7 vertices and source.obj has 6"));
  EXPECT_THAT(refused(strip("hole.obj", 1.0, 0.0, "f 1 2 4\nf 2 5 6\n")), HasSubstr("no face has vertex 3"));
  EXPECT_THAT(refused(strip("other.obj", 1.0, 0.0, "f 1 3 5\nf 2 4 6\n")), HasSubstr("join other vertices"));
  EXPECT_THAT(refused(write("unit.obj", std::string("v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nv 200 0 0\n"
                                                    "v 200 100 0\n") +
                                            kFaces)),
              HasSubstr("100"));
}

}  // namespace
}  // namespace furrow::pipeline
