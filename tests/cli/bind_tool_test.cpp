// `furrow bind`: a copy of the mesh, a copy in other units and axes, a stranger.

#include <cmath>
#include <functional>
#include <glm/vec3.hpp>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

// A hilly sheet of 6 x 6 quads as OBJ, every face with vertices of its own if `split`.
std::string sheet(bool split, const std::function<glm::dvec3(glm::dvec3)>& place) {
  std::string vertices, faces;
  int count = 0;
  const auto vertex = [&](int x, int y) {
    const glm::dvec3 p = place({x / 6.0, y / 6.0, 0.1 * std::sin(1.7 * x) * std::cos(2.3 * y)});
    char line[100];
    std::snprintf(line, sizeof line, "v %.6f %.6f %.6f\n", p.x, p.y, p.z);
    vertices += line;
    return ++count;
  };
  if (!split)
    for (int y = 0; y <= 6; ++y)
      for (int x = 0; x <= 6; ++x) vertex(x, y);
  for (int y = 5; y >= 0; --y)
    for (int x = 0; x < 6; ++x) {
      faces += "f";
      for (const auto& [i, j] : {std::pair(x, y), {x + 1, y}, {x + 1, y + 1}, {x, y + 1}})
        faces += ' ' + std::to_string(split ? vertex(i, j) : j * 7 + i + 1);
      faces += '\n';
    }
  return vertices + faces;
}

glm::dvec3 same(glm::dvec3 p) {
  return p;
}
glm::dvec3 centimetresZUp(glm::dvec3 p) {
  return 100.0 * glm::dvec3(p.x, -p.z, p.y);
}

class BindTool : public ToolTest {
 protected:
  std::filesystem::path mesh = write("sheet.obj", sheet(false, same));
  std::filesystem::path asset = folder() / "sheet.furrow";

  void SetUp() override { ASSERT_EQ(run({"cook", mesh, "-o", asset, "--quiet"}).status, 0); }
};

TEST_F(BindTool, ASplitCopyBinds) {
  const std::filesystem::path csv = output() / "points.csv";
  const Outcome outcome = run({"bind", asset, write("split.obj", sheet(true, same)), "-o", csv});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "vertices 144\nmatched 144\nambiguous 0\nunmatched 0\n");
  const std::string text = readText(csv);
  EXPECT_TRUE(text.starts_with("vertex,point\n0,"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 145);
}

TEST_F(BindTool, OtherUnitsAndAxesBindByTheirSimilarity) {
  const std::filesystem::path other = write("other.obj", sheet(true, centimetresZUp));
  const std::vector<std::vector<std::string>> similarities = {
      {"--scale", "0.01", "--up", "z"},
      {"--matrix", "0.01", "0", "0", "0", "0", "0", "0.01", "0", "0", "-0.01", "0", "0"}};
  for (std::vector<std::string> arguments : similarities) {
    arguments.insert(arguments.begin(), {"bind", asset, other});
    arguments.insert(arguments.end(), {"--tolerance", "0.00001"});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "vertices 144\nmatched 144\nambiguous 0\nunmatched 0\n");
  }
  EXPECT_EQ(run({"bind", asset, other}).status, 1);
}

TEST_F(BindTool, AStrangerIsRefusedWithItsCounts) {
  const auto stranger = write("stranger.obj", sheet(false, [](glm::dvec3 p) { return p + 0.5; }));
  const Outcome outcome =
      run({"bind", asset, stranger, "--tolerance", "0.00001", "-o", output() / "points.csv"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out, "vertices 49\nmatched 0\nambiguous 0\nunmatched 49\n");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("stranger.obj"), std::string::npos) << outcome.err;
  expectNothingLeft();
}

TEST_F(BindTool, TheListOfPointsReplacesNoInput) {
  for (const std::filesystem::path& input : {asset, mesh})
    expectRefused(run({"bind", asset, mesh, "-o", input}), 2, input);
  EXPECT_EQ(run({"bind", asset, mesh}).status, 0);
}

TEST_F(BindTool, WrongOptionsAreBadUsage) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--matrix", "1", "0", "0", "0", "0", "2", "0", "0", "0", "0", "1", "0"},
      {"--matrix", "1", "0", "0"},
      {"--scale", "-1"},
      {"--scale", "nan"},
      {"--up", "q"},
      {"--tolerance", "-1"}};
  for (std::vector<std::string> arguments : wrong) {
    arguments.insert(arguments.begin(), {"bind", asset, mesh});
    expectRefused(run(arguments), 2, "--");
  }
}

}  // namespace
}  // namespace furrow::test
