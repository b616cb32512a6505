// The shader library, run as it is: every case is a line of GLSL in a compute shader.

#include <epoxy/gl.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "editor/preview/shaders/lighting.h"
#include "shade_text.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

struct Vec4 {
  float x, y, z, w;
};

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

class ShadeTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!IsSkipped() && !support_.gpu) GTEST_SKIP() << support_.reason;
  }

  // result[i] = body(input[i]); `body` is GLSL between "vec4 f(vec4 v) {" and "}", `before` stands in front
  // of the library.
  static std::vector<Vec4> run(const std::vector<Vec4>& input, const std::string& body,
                               const std::string& before = {}) {
    const std::string text = "#version 430\n" + before + shade_text::kFurrowShade +
                             "layout(local_size_x = 64) in;\n"
                             "layout(std430, binding = 0) readonly buffer In { vec4 given[]; };\n"
                             "layout(std430, binding = 1) writeonly buffer Out { vec4 result[]; };\n"
                             "vec4 f(vec4 v) {\n" +
                             body +
                             "\n}\n"
                             "void main() { uint i = gl_GlobalInvocationID.x; if (i < given.length()) "
                             "result[i] = f(given[i]); }\n";
    const char* source = text.c_str();
    const GLuint program = glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &source);
    char log[512] = {};
    glGetProgramInfoLog(program, sizeof log, nullptr, log);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    EXPECT_TRUE(linked) << log;
    std::vector<Vec4> output(input.size(), {NAN, NAN, NAN, NAN});
    const auto bytes = static_cast<GLsizeiptr>(input.size() * sizeof(Vec4));
    GLuint buffers[2];
    glGenBuffers(2, buffers);
    for (GLuint i = 0; i < 2; ++i) {
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
      glBufferData(GL_SHADER_STORAGE_BUFFER, bytes, i == 0 ? input.data() : output.data(), GL_STATIC_DRAW);
    }
    glUseProgram(program);
    glDispatchCompute(static_cast<GLuint>(input.size() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, bytes, output.data());
    glDeleteBuffers(2, buffers);
    glDeleteProgram(program);
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    return output;
  }

  // Largest angle between furrowScale and furrowScaleFast over I in [0, 1], in degrees, for a normal with x^2
  // + y^2 = r2.
  static double fastError(double r2) {
    constexpr int kSteps = 1000;
    std::vector<Vec4> input;
    for (int i = 0; i <= kSteps; ++i) {
      const double turn = 0.7 * i, r = std::sqrt(r2);
      input.push_back({static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)),
                       static_cast<float>(std::sqrt(1.0 - r2)), static_cast<float>(i) / kSteps});
    }
    const auto exact = run(input, "return vec4(furrowScale(v.xyz, v.w), 0.0);");
    const auto fast = run(input, "return vec4(furrowScaleFast(v.xyz, v.w), 0.0);");
    double worst = 0.0;
    for (size_t i = 0; i < input.size(); ++i) {
      const Vec4 a = exact[i], b = fast[i];
      const double cx = double(a.y) * b.z - double(a.z) * b.y, cy = double(a.z) * b.x - double(a.x) * b.z,
                   cz = double(a.x) * b.y - double(a.y) * b.x;
      const double dot = double(a.x) * b.x + double(a.y) * b.y + double(a.z) * b.z;
      worst = std::max(worst, degrees(std::atan2(std::sqrt(cx * cx + cy * cy + cz * cz), dot)));
      EXPECT_NEAR(std::sqrt(double(b.x) * b.x + double(b.y) * b.y + double(b.z) * b.z), 1.0, 1e-6);
    }
    return worst;
  }
};

TEST_F(ShadeTest, FastNormalisationStaysWithinLarssonsBound) {
  EXPECT_NEAR(fastError(0.6), 8.75, 0.01);   // "at most 8.75 degrees"
  EXPECT_NEAR(fastError(0.635), 10.0, 0.1);  // "10 degrees near 0.64"
  double before = 0.0;
  for (int i = 1; i <= 12; ++i) {  // grows with the slope, so that the bound holds below 0.6 as well
    const double error = fastError(0.05 * i);
    EXPECT_GT(error, before);
    before = error;
  }
}

TEST_F(ShadeTest, FastNormalisationTableOfTheHeaderIsTrue) {
  const std::string text = shade_text::kFurrowShade;
  const auto row = [&](const std::string& name) {
    const size_t begin = text.find("//   " + name) + 5 + name.size();
    std::vector<double> numbers;
    std::string line = text.substr(begin, text.find('\n', begin) - begin);
    for (size_t at = 0; (at = line.find_first_of("0123456789", at)) != std::string::npos;) {
      size_t used = 0;
      numbers.push_back(std::stod(line.substr(at), &used));
      at += used;
    }
    return numbers;
  };
  const auto squares = row("x^2 + y^2"), errors = row("degrees");
  ASSERT_EQ(squares.size(), 10u);
  ASSERT_EQ(errors.size(), squares.size());
  for (size_t i = 0; i < squares.size(); ++i)
    EXPECT_NEAR(fastError(squares[i]), errors[i], 0.06) << squares[i];
}

TEST_F(ShadeTest, DecodesUnitNormalsAndEndsSlopes) {
  const auto n = run({{0.5f, 0.5f, 0, 0}, {0.8f, 0.5f, 0, 0}, {0.2f, 0.9f, 0, 0}, {1.0f, 1.0f, 0, 0}},
                     "vec3 n = furrowDecodeNormal(v.xy); return vec4(n, length(furrowSlope(n)));");
  EXPECT_FLOAT_EQ(n[0].x, 0.0f);
  EXPECT_FLOAT_EQ(n[0].z, 1.0f);
  EXPECT_NEAR(n[1].x, 0.6f, 1e-6f);
  EXPECT_NEAR(n[1].z, 0.8f, 1e-6f);
  EXPECT_NEAR(n[2].w, std::sqrt(257.0f), 1e-2f);  // on the unit circle
  EXPECT_TRUE(std::isfinite(n[3].w));
}

TEST_F(ShadeTest, InterpolatedBumpMappingIsTheSlopeScaled) {
  const auto slopes =
      run({{0.6f, 0.0f, 0.8f, 0.25f}, {-0.3f, 0.5f, std::sqrt(0.66f), 0.7f}},
          "vec2 a = furrowSlope(furrowScale(v.xyz, v.w)), b = furrowSlope(v.xyz) * v.w; return vec4(a, b);");
  for (const Vec4& s : slopes) {
    EXPECT_NEAR(s.x, s.z, 1e-6f);
    EXPECT_NEAR(s.y, s.w, 1e-6f);
  }
}

// Three normals of known slope in six orders: gradients add their slopes whatever the order.
TEST_F(ShadeTest, GradientsAddInAnyOrder) {
  const std::string slopes =
      "vec3 n[3] = vec3[3](normalize(vec3(0.7, 0.1, 1)), normalize(vec3(-0.2, 0.9, 1)), normalize(vec3(0.4, "
      "-0.3, 1)));\n"
      "ivec3 o = ivec3(v.xyz);\n";
  const std::vector<Vec4> orders = {{0, 1, 2, 0}, {0, 2, 1, 0}, {1, 0, 2, 0},
                                    {1, 2, 0, 0}, {2, 0, 1, 0}, {2, 1, 0, 0}};
  const auto pairwise =
      run(orders, slopes +
                      "vec3 r = furrowCombineGradients(furrowCombineGradients(n[o.x], n[o.y]), n[o.z]);"
                      "return vec4(furrowSlope(r), length(r), 0);");
  const auto layered =
      run(orders, slopes +
                      "FurrowWrinkles w = furrowBegin(n[o.x]); furrowAddNormal(w, n[o.y], 1.0);"
                      "furrowAddNormal(w, n[o.z], 1.0); vec3 r = furrowNormal(w);"
                      "return vec4(furrowSlope(r), length(r), 0);");
  for (const auto& results : {pairwise, layered})
    for (const Vec4& r : results) {
      EXPECT_NEAR(r.x, 0.9f, 1e-5f);
      EXPECT_NEAR(r.y, 0.7f, 1e-5f);
      EXPECT_NEAR(r.z, 1.0f, 1e-6f);
    }
}

// A flat detail changes nothing and a flat base gives the detail, for every way to combine.
TEST_F(ShadeTest, FlatNormalsAreNeutral) {
  for (const char* combine : {"Gradients", "Whiteout", "Reoriented"}) {
    const std::string call = std::string("furrowCombine") + combine;
    const auto r = run({{0.3f, -0.5f, std::sqrt(0.66f), 0}},
                       "vec3 flat_normal = vec3(0, 0, 1);"
                       "return vec4(distance(" +
                           call + "(flat_normal, v.xyz), v.xyz), distance(" + call +
                           "(v.xyz, flat_normal), v.xyz), 0, 0);");
    EXPECT_NEAR(r[0].x, 0.0f, 1e-6f) << combine;
    EXPECT_NEAR(r[0].y, 0.0f, 1e-6f) << combine;
  }
}

// Reorienting tilts the detail with the base: a detail and a base in one plane add their angles.
TEST_F(ShadeTest, ReorientedNormalsAddAngles) {
  const float a = 0.3f, b = 0.5f;
  const auto r =
      run({{a, b, 0, 0}},
          "vec3 r = furrowCombineReoriented(vec3(sin(v.x), 0, cos(v.x)), vec3(sin(v.y), 0, cos(v.y)));"
          "return vec4(r, length(r));");
  EXPECT_NEAR(std::atan2(r[0].x, r[0].z), a + b, 1e-5f);
  EXPECT_NEAR(r[0].w, 1.0f, 1e-6f);
}

TEST_F(ShadeTest, WhiteoutIsOatsFormula) {
  const auto r = run(
      {{0, 0, 0, 0}},
      "vec3 a = vec3(0.6, 0, 0.8), b = vec3(0, 0.28, 0.96); return vec4(furrowCombineWhiteout(a, b), 0);");
  const double x = 0.6, y = 0.28, z = 0.8 * 0.96, length = std::sqrt(x * x + y * y + z * z);
  EXPECT_NEAR(r[0].x, x / length, 1e-6);
  EXPECT_NEAR(r[0].y, y / length, 1e-6);
  EXPECT_NEAR(r[0].z, z / length, 1e-6);
}

TEST_F(ShadeTest, LarssonsOtherMethods) {
  const auto r =
      run({{0.5f, 0.4f, 0, 0}},
          "return vec4(furrowAlphaShade(vec3(0.8), v.x, v.y).x, furrowBlend(vec3(1), vec3(3), 0.25).x,"
          "furrowFade(0.05), furrowFade(-0.2) + furrowFade(0.7));");
  EXPECT_NEAR(r[0].x, 0.8f * (1.0f - 0.5f * 0.4f), 1e-6f);
  EXPECT_NEAR(r[0].y, 1.5f, 1e-6f);
  EXPECT_NEAR(r[0].z, 0.4f, 1e-6f);
  EXPECT_NEAR(r[0].w, 1.0f, 1e-6f);
}

// Averaging unit normals of small random slopes loses as much length as their slopes vary.
TEST_F(ShadeTest, LostLengthIsSlopeVariance) {
  double sum[3] = {}, squares = 0.0;
  constexpr int kCount = 4096;
  for (int i = 0; i < kCount; ++i) {  // a grid of slopes with deviation 0.1 along each axis
    const double x = 0.2 * std::sqrt(3.0) * ((i % 64 + 0.5) / 64 - 0.5),
                 y = 0.2 * std::sqrt(3.0) * ((i / 64 + 0.5) / 64 - 0.5);
    const double length = std::sqrt(x * x + y * y + 1.0);
    sum[0] += x / length, sum[1] += y / length, sum[2] += 1.0 / length;
    squares += x * x;
  }
  const auto r = run({{static_cast<float>(sum[0] / kCount), static_cast<float>(sum[1] / kCount),
                       static_cast<float>(sum[2] / kCount), 0}},
                     "return vec4(furrowLostVariance(v.xyz), furrowRoughness(0.5, 0.0), furrowRoughness(0.5, "
                     "0.01), furrowRoughness(0.9, 1.0));");
  EXPECT_NEAR(r[0].x, squares / kCount, 0.03 * squares / kCount);
  EXPECT_NEAR(r[0].y, 0.5f, 1e-6f);
  EXPECT_NEAR(std::pow(r[0].z, 4.0f), 0.0625f + 0.02f, 1e-5f);
  EXPECT_NEAR(r[0].w, 1.0f, 1e-6f);
}

// furrowAddLayer picks the compress map above 0 and the stretch map below, and the layer's channel of the
// mask.
TEST_F(ShadeTest, AddLayerPicksMapsAndMask) {
  const std::string maps =
      "#define FURROW_WINDOW(slice) vec4(0.0, 0.0, 1.0, 1.0)\n"
      "#define FURROW_NORMAL(at, slice, zoom) (slice == 3u ? vec2(0.8, 0.5) : vec2(0.5, 0.8))\n"
      "#define FURROW_SHADING(at, slice, zoom) (slice == 3u ? 0.5 : 0.25)\n"
      "#define FURROW_MASK(uv, slice) (vec4(0.0, 0.5, 0.0, 1.0) * float(slice))\n";
  const std::string layer =
      "FurrowWrinkles w = furrowBegin(vec3(0, 0, 1)); furrowAddLayer(w, v.x, uvec4(3u, v.z > 0.0 ? 4u : "
      "FURROW_NO_SLICE, "
      "5u, 0u), vec2(0)); return vec4(furrowSlope(furrowNormal(w)), w.shading, 0);";
  const auto r =
      run({{1, 0, 1, 0}, {-1, 0, 1, 0}, {-1, 0, 0, 0}, {0, 0, 1, 0}, {0.5f, 0, 1, 0}}, layer, maps);
  // Slope 0.75, half of it through channel 5 % 4 of slice 5 / 4.
  EXPECT_NEAR(r[0].x, 0.375f, 1e-5f);
  EXPECT_NEAR(r[0].z, 1.0f - 0.5f * 0.5f, 1e-6f);
  EXPECT_NEAR(r[1].y, 0.375f, 1e-5f);
  EXPECT_NEAR(r[1].x, 0.0f, 1e-6f);
  EXPECT_NEAR(r[1].z, 1.0f - 0.5f * 0.25f, 1e-6f);
  for (size_t i : {2, 3}) {
    EXPECT_EQ(r[i].x, 0.0f);
    EXPECT_EQ(r[i].z, 1.0f);
  }
  EXPECT_NEAR(r[4].x, 0.1875f, 1e-5f);
}

// A map that covers u from 0.9 over a fifth, across the border of the unit square, and v from 0.25 over a
// half.
TEST_F(ShadeTest, AddLayerLooksIntoTheWindowOfAMap) {
  const std::string maps =
      "vec2 seen, zoomed;\n"
      "#define FURROW_WINDOW(slice) vec4(0.9, 0.25, 5.0, 2.0)\n"
      "#define FURROW_NORMAL(at, slice, zoom) (seen = at, zoomed = zoom, vec2(0.8, 0.5))\n"
      "#define FURROW_SHADING(at, slice, zoom) 0.5\n";
  const std::string layer =
      "seen = vec2(-1); zoomed = vec2(0); FurrowWrinkles w = furrowBegin(vec3(0, 0, 1)); furrowAddLayer(w, "
      "1.0, "
      "uvec4(0u, 0u, 0u, 0u), v.xy); return vec4(seen, zoomed);";
  const auto r = run({{0.95f, 0.5f, 0, 0},
                      {0.05f, 0.5f, 0, 0},
                      {-0.95f, 1.3f, 0, 0},
                      {0.5f, 0.5f, 0, 0},
                      {0.95f, 0.2f, 0, 0}},
                     layer, maps);
  EXPECT_NEAR(r[0].x, 0.25f, 1e-5f);
  EXPECT_NEAR(r[0].y, 0.5f, 1e-5f);
  EXPECT_EQ(r[0].z, 5.0f);
  EXPECT_EQ(r[0].w, 2.0f);
  EXPECT_NEAR(r[1].x, 0.75f, 1e-5f);
  EXPECT_NEAR(r[2].x, 0.75f, 1e-5f);
  EXPECT_NEAR(r[2].y, 0.1f, 1e-5f);
  for (size_t i : {3, 4}) EXPECT_EQ(r[i].x, -1.0f);  // beside it
}

TEST_F(ShadeTest, EveryCombinationCompilesAndAgreesOnOneLayer) {
  const std::string body =
      "FurrowWrinkles w = furrowBegin(vec3(0, 0, 1)); furrowAddNormal(w, v.xyz, v.w); return "
      "vec4(furrowNormal(w), 0);";
  const std::vector<Vec4> input = {{0.3f, -0.5f, std::sqrt(0.66f), 0.4f}};
  const Vec4 first = run(input, body, "#define FURROW_COMBINE 0\n")[0];
  for (const char* other : {"#define FURROW_COMBINE 1\n", "#define FURROW_COMBINE 2\n"}) {
    const Vec4 r = run(input, body, other)[0];
    EXPECT_NEAR(r.x, first.x, 1e-6f);
    EXPECT_NEAR(r.y, first.y, 1e-6f);
    EXPECT_NEAR(r.z, first.z, 1e-6f);
  }
}

// Larsson's equations 12 and 13: light comes in over the terminator within an eighth, whatever the bump.
TEST(Lighting, BlinnFadesWhereTheSurfaceTurnsAway) {
  using glm::vec3;
  const vec3 l(0, 0, 1), up(0, 1, 0), view(0, 0, 1), base(0.5f);
  const glm::vec4 lights[3] = {glm::vec4(l, 1.0f), glm::vec4(l, 0.0f), glm::vec4(l, 0.0f)};
  const vec3 bumped = glm::normalize(vec3(0, 0.3f, 1));
  const auto lit = [&](float cosine) {
    const vec3 form(std::sqrt(1.0f - cosine * cosine), 0, cosine);
    return preview::gpu::shadeBlinn(lights, up, base, form, bumped, view, 1.0f, 0.5f, 1.0f).g;
  };
  const float sky = lit(-0.2f), all = lit(0.125f) - sky;
  EXPECT_GT(all, 0.3f);
  EXPECT_EQ(lit(0.0f), sky);
  EXPECT_NEAR(lit(1.0f / 16.0f) - sky, 0.5f * all, 1e-5f);
  EXPECT_NEAR(lit(0.9f) - sky, all, 1e-5f);
  // In shadow nothing of the key is left.
  EXPECT_NEAR(preview::gpu::shadeBlinn(lights, up, base, l, bumped, view, 1.0f, 0.5f, 0.0f).g, sky, 1e-6f);
}

}  // namespace
}  // namespace furrow::tests
