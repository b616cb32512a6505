#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>

#include "content/models.h"
#include "content/surface_mesh.h"

// The left arm of a T pose: along +X, the inner side of the elbow to +Z, the thumb side up. Metres.

namespace furrow::content {
namespace {

constexpr double kPi = glm::pi<double>();
constexpr double kElbow = 0.28, kWrist = 0.53;
constexpr double kCuff = 0.455, kHem = 0.505;  // where the cuff begins, and where it ends
constexpr glm::dvec3 kElbowJoint{kElbow, 0.0, 0.012};

enum Joint : uint8_t { kUpperArm, kForeArm, kForeArmTwist, kHand };

double gauss(double x) {
  return std::exp(-x * x);
}

double armRadius(double x) {
  const double upper = 0.047 + 0.006 * gauss((x - 0.13) / 0.09);
  const double fore = 0.028 + 0.016 * gauss((x - 0.34) / 0.09);
  return glm::mix(upper, fore, smoothRamp(0.2, 0.34, x));
}

// Wide at the shoulder, loose about the elbow, blousing over a cuff that takes it in.
double sleeveRadius(double x) {
  const double cloth = glm::mix(0.083, 0.060, smoothRamp(0.0, 0.44, x)) + 0.004 * gauss((x - 0.41) / 0.035);
  return glm::mix(cloth, 0.0435, smoothRamp(kCuff - 0.028, kCuff, x));
}

// Slack that the cloth keeps while the arm is straight: a few soft folds across the sleeve, deepest inside
// the elbow and over the cuff.
double slack(double x, double angle) {
  const double inner = 0.5 + 0.5 * std::cos(angle);
  const double elbow = 0.0022 * gauss((x - kElbow) / 0.055) * inner *
                       std::sin(2 * kPi * x / 0.045 + 0.8 * std::sin(2 * angle));
  const double blouse = 0.0016 * gauss((x - 0.425) / 0.02) * std::sin(5 * angle + 9 * std::sin(x * 40));
  const double drape =
      0.0018 * std::sin(3 * angle + 7 * x) * smoothRamp(0.0, 0.1, x) * smoothRamp(kCuff, kCuff - 0.1, x);
  return elbow + blouse + drape;
}

struct Influence {
  glm::u8vec4 joints{kUpperArm, kForeArm, kForeArmTwist, kHand};
  glm::vec4 weights;
};

// The elbow over `width` to either side, then the twist handed down the forearm.
Influence influence(double x, double width) {
  const double bend = smoothRamp(kElbow - width, kElbow + width, x);
  const double half = smoothRamp(kElbow + 0.03, kElbow + 0.14, x);
  const double full = smoothRamp(kElbow + 0.10, kWrist - 0.04, x);
  Influence result;
  result.weights = glm::vec4(1 - bend, bend * (1 - half), bend * half * (1 - full), bend * half * full);
  result.weights /= result.weights.x + result.weights.y + result.weights.z + result.weights.w;
  for (int k = 0; k < 4; ++k)
    if (result.weights[k] == 0) result.joints[k] = 0;
  return result;
}

// A tube along X, point (ring, spoke) at profile[ring] = (x, radius); the seam is at the back of the arm.
struct Tube {
  SurfaceMesh mesh;
  // A point: x on the unrolled cloth (metres from the shoulder), angle from +Z towards +Y.
  std::vector<glm::dvec2> place;
};

template <class Radius>
Tube tube(std::span<const glm::dvec2> profile, uint32_t spokes, Radius&& radius) {
  Tube result;
  const auto angleOf = [&](uint32_t spoke) { return kPi + 2 * kPi * spoke / spokes; };
  double length = 0;
  std::vector<double> along(profile.size());
  for (uint32_t ring = 1; ring < profile.size(); ++ring)
    along[ring] = length += glm::distance(profile[ring - 1], profile[ring]);
  for (uint32_t ring = 0; ring < profile.size(); ++ring) {
    for (uint32_t spoke = 0; spoke < spokes; ++spoke) {
      const double angle = angleOf(spoke), x = profile[ring].x, r = radius(profile[ring], angle);
      result.mesh.points.emplace_back(x, r * std::sin(angle), r * std::cos(angle));
      result.place.emplace_back(x, angle);
    }
  }
  for (uint32_t ring = 0; ring < profile.size(); ++ring)
    for (uint32_t spoke = 0; spoke <= spokes; ++spoke)
      result.mesh.addVertex(ring * spokes + spoke % spokes,
                            {0.02 + 0.96 * spoke / spokes, 0.02 + 0.96 * along[ring] / length});
  for (uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (uint32_t spoke = 0; spoke < spokes; ++spoke) {
      const uint32_t a = ring * (spokes + 1) + spoke, b = a + spokes + 1;
      result.mesh.addQuad(a, b, b + 1, a + 1);
    }
  }
  return result;
}

Primitive finish(const Tube& source, uint32_t material, double elbow_width) {
  Primitive primitive;
  primitive.material = material;
  const std::vector<glm::dvec3> normals = pointNormals(source.mesh, source.mesh.points);
  for (const SurfaceMesh::Vertex& vertex : source.mesh.vertices) {
    primitive.positions.emplace_back(source.mesh.points[vertex.point]);
    primitive.normals.emplace_back(normals[vertex.point]);
    primitive.uvs.emplace_back(vertex.uv);
    const Influence skin = influence(source.place[vertex.point].x, elbow_width);
    primitive.joints.push_back(skin.joints);
    primitive.weights.push_back(skin.weights);
  }
  for (const SurfaceMesh::Triangle& triangle : source.mesh.triangles)
    primitive.indices.insert(primitive.indices.end(), triangle.vertices.begin(), triangle.vertices.end());
  return primitive;
}

Primitive cloth() {
  constexpr uint32_t kRings = 118, kSpokes = 72;
  std::vector<glm::dvec2> profile;
  for (uint32_t i = 0; i <= kRings; ++i) {
    const double x = 0.03 + (kHem - 0.03) * i / kRings;
    // The cuff is a band of its own thickness that stands off the cloth it gathers.
    const double cuff = 0.0022 * smoothRamp(kCuff - 0.001, kCuff + 0.003, x);
    profile.emplace_back(x, sleeveRadius(x) + cuff);
  }
  const double rim = profile.back().y;
  profile.emplace_back(kHem + 0.0012, rim - 0.0006);
  profile.emplace_back(kHem + 0.0012, rim - 0.0022);
  for (double inside : {0.0, 0.006, 0.014, 0.024}) profile.emplace_back(kHem - inside, rim - 0.003);

  Tube sleeve = tube(profile, kSpokes, [](glm::dvec2 p, double angle) { return p.y + slack(p.x, angle); });
  Primitive primitive = finish(sleeve, 0, 0.115);

  std::vector<glm::vec4> mask;
  std::vector<glm::vec3> twist_left, twist_right;
  for (size_t v = 0; v < primitive.positions.size(); ++v) {
    const auto [x, angle] = std::pair(sleeve.place[sleeve.mesh.vertices[v].point].x,
                                      sleeve.place[sleeve.mesh.vertices[v].point].y);
    const double inner = smoothRamp(-0.55, 0.45, std::cos(angle));
    const double elbow = inner * bump((x - kElbow) / 0.13);
    const double forearm =
        smoothRamp(kElbow - 0.01, kElbow + 0.05, x) * smoothRamp(kCuff + 0.002, kCuff - 0.02, x);
    mask.emplace_back(
        elbow, forearm,
        smoothRamp(kCuff - 0.05, kCuff - 0.015, x) * smoothRamp(kCuff + 0.002, kCuff - 0.004, x), 0.0);
    const double bias =
        0.5 + 0.14 * inner * gauss((x - kElbow) / 0.035) + 0.22 * gauss((x - (kCuff - 0.018)) / 0.016);
    primitive.colors.emplace_back(glm::vec3(static_cast<float>(bias)), 1.0f);
    const glm::dvec3 around(0, std::cos(angle), -std::sin(angle));
    twist_left.emplace_back(glm::normalize(glm::dvec3(1, 0, 0) + around));
    twist_right.emplace_back(glm::normalize(glm::dvec3(1, 0, 0) - around));
  }
  primitive.vec4_attributes.emplace_back("_MASK_A", std::move(mask));
  primitive.vec3_attributes.emplace_back("_DIR_TWIST_LEFT", std::move(twist_left));
  primitive.vec3_attributes.emplace_back("_DIR_TWIST_RIGHT", std::move(twist_right));
  return primitive;
}

Primitive arm() {
  constexpr uint32_t kRings = 60, kSpokes = 36, kCap = 10;
  constexpr double kEnd = kWrist + 0.035;
  std::vector<glm::dvec2> profile;
  for (uint32_t i = 0; i <= kRings; ++i) {
    const double x = (kEnd - 0.02) * i / kRings;
    profile.emplace_back(x, armRadius(x));
  }
  const glm::dvec2 last = profile.back();
  for (uint32_t i = 1; i <= kCap; ++i) {
    const double t = 0.5 * kPi * i / kCap;
    profile.emplace_back(last.x + 0.02 * std::sin(t), std::max(1e-4, last.y * std::cos(t)));
  }
  return finish(tube(profile, kSpokes, [](glm::dvec2 p, double) { return p.y; }), 1, 0.06);
}

// Every joint turned about its axis by `degrees` times phase(t), t from 0 to 1.
template <class Phase>
Clip swing(std::string name, double seconds, double degrees,
           std::span<const std::pair<uint32_t, glm::vec3>> joints, Phase&& phase) {
  Clip clip;
  clip.name = std::move(name);
  for (const auto& joint : joints) clip.rotations.push_back({joint.first, {}});
  const int keys = static_cast<int>(seconds * 30);
  for (int key = 0; key <= keys; ++key) {
    const double t = static_cast<double>(key) / keys;
    clip.times.push_back(static_cast<float>(t * seconds));
    const float angle = static_cast<float>(glm::radians(degrees * phase(t)));
    for (size_t i = 0; i < joints.size(); ++i)
      clip.rotations[i].rotations.push_back(glm::angleAxis(angle, joints[i].second));
  }
  return clip;
}

}  // namespace

Scene buildSleeve() {
  Scene scene;
  scene.materials = {{"cloth", {0.36f, 0.43f, 0.56f}, 0.85f, true},
                     {"skin", {0.80f, 0.55f, 0.42f}, 0.55f, false}};
  scene.nodes = {{"Rig", -1, {}},
                 {"upperArm", 0, {}},
                 {"foreArm", 1, glm::vec3(kElbowJoint)},
                 {"foreArmTwist", 2, glm::vec3(0.10f, 0.0f, -static_cast<float>(kElbowJoint.z))},
                 {"hand", 3, glm::vec3(kWrist - kElbow - 0.10, 0.0, 0.0)}};
  scene.joints = {1, 2, 3, 4};
  scene.meshes = {{"Sleeve", {}, {cloth()}, {}}, {"Arm", {}, {arm()}, {}}};
  scene.nodes.push_back({"Sleeve", -1, {}, 0, true});
  scene.nodes.push_back({"Arm", -1, {}, 1, true});
  // The forearm comes forward about -Y; it turns about its own length, half in each of the two joints.
  const std::pair<uint32_t, glm::vec3> elbow[] = {{2, {0, -1, 0}}},
                                       twist[] = {{3, {1, 0, 0}}, {4, {1, 0, 0}}};
  const auto outAndBack = [](double t) { return 0.5 - 0.5 * std::cos(2 * kPi * t); };
  const auto toBothSides = [](double t) { return std::sin(2 * kPi * t); };
  scene.clips = {swing("bend", 2.0, 110, elbow, outAndBack), swing("twist", 3.0, 40, twist, toBothSides)};
  return scene;
}

}  // namespace furrow::content
