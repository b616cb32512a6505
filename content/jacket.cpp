#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>

#include "content/models.h"
#include "content/noise.h"
#include "content/solids.h"
#include "content/surface_mesh.h"
#include "content/surface_net.h"

// The jacket is cut out of the surface about a torso and two arms, like the head sculpted as a distance;
// knitted bands close its edges. Centimetres until the end; x to the wearer's left, y up, z to the front, the
// origin between the armpits.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();
constexpr double kHem = -38.5, kCuff = 49.5, kUpperLength = 28.0, kNeck = 7.6;
constexpr dvec3 kShoulder{17.5, 8.0, -1.0}, kCollarbone{2.5, 9.0, -1.0}, kNeckMiddle{0.0, 0.0, -1.6};

enum JacketMaterial : uint32_t { kCloth, kKnit, kZip };
// Joints; a shoulder and an elbow turn half as far as what they carry, so that the cloth about them keeps its
// thickness. A collarbone lifts the shoulder. Of the right arm: kArmJoints further on.
enum Joint : uint8_t { kHips, kSpine, kChest, kClavicle, kShoulderHalf, kUpperArm, kElbowHalf, kForeArm };
constexpr uint8_t kArmJoints = 5;

double gauss(double x) {
  return std::exp(-x * x);
}

// The left arm hangs away from the body: down its upper arm, then along the forearm, which comes forward.
struct Arm {
  dvec3 upper = glm::normalize(dvec3(0.80, -0.60, 0.0)), fore = glm::normalize(dvec3(0.72, -0.64, 0.27));
  dvec3 elbow = kShoulder + kUpperLength * upper, wrist = elbow + 25.0 * fore;
};
const Arm kArm;

// A place on the jacket. `side` is -1 on the wearer's right, where the rest is that of the mirror image.
struct Place {
  double side;
  double along;   // the arm from the shoulder
  double sleeve;  // how far it belongs to the arm, [0, 1]
  dvec3 axis;     // of the arm there
  double turn;    // about the arm, from the front over the top
};

double torsoDistance(dvec3 m) {
  const dvec3 flat(m.x, m.y, m.z * 1.42);
  double d = limb(flat, {0, -2, 0}, {0, -60, 0}, 16.2, 15.6);
  d = join(d, ellipsoid(m, {0, 2.5, -0.6}, {17.6, 14.0, 11.4}), 4.0);
  d = join(d, limb(m, {5.0, 13.2, -2.4}, {16.0, 9.6, -1.2}, 5.0, 6.4), 3.0);
  return d;
}

double armDistance(dvec3 m) {
  return join(limb(m, kShoulder, kArm.elbow, 8.3, 7.0),
              limb(m, kArm.elbow, kArm.elbow + 40.0 * kArm.fore, 7.0, 4.9), 1.5);
}

Place placeOf(dvec3 p) {
  const dvec3 m(std::abs(p.x), p.y, p.z);
  Place place;
  place.side = p.x < 0 ? -1 : 1;
  const double upper = glm::dot(m - kShoulder, kArm.upper), fore = glm::dot(m - kArm.elbow, kArm.fore);
  const double beyond = smoothRamp(kUpperLength - 6, kUpperLength + 6, upper);
  place.along = glm::mix(upper, kUpperLength + fore, beyond);
  place.axis = glm::normalize(glm::mix(kArm.upper, kArm.fore, beyond));
  place.sleeve =
      smoothRamp(5.5, -5.5, armDistance(m) - torsoDistance(m)) * smoothRamp(-9.0, 7.0, place.along);
  const dvec3 on_axis = fore > 0 ? kArm.elbow + fore * kArm.fore : kShoulder + upper * kArm.upper;
  const dvec3 over = glm::normalize(glm::cross(dvec3(0, 0, 1), place.axis)),
              forward = glm::cross(place.axis, over);
  place.turn = std::atan2(glm::dot(m - on_axis, over), glm::dot(m - on_axis, forward));
  return place;
}

double distance(dvec3 p) {
  const dvec3 m(std::sqrt(p.x * p.x + 0.25), p.y, p.z);
  double d = join(torsoDistance(m), armDistance(m), 6.0);
  const Place place = placeOf(p);
  // Cloth hangs over the bands that gather it, and falls in soft folds of its own.
  const double body = 1 - place.sleeve;
  d -= 1.1 * body * gauss((p.y - kHem - 4.5) / 3.6) +
       0.9 * place.sleeve * gauss((place.along - kCuff + 4.5) / 3.6);
  const double drape = valueNoise(dvec3(m.x * 0.13, m.y * 0.07, p.z * 0.13) + dvec3(3)) * 0.55 * body +
                       valueNoise(m * 0.16 + dvec3(11)) * 0.45 * place.sleeve;
  const double elbow = 0.28 * place.sleeve * gauss((place.along - kUpperLength) / 8.0) *
                       std::sin(2 * kPi * place.along / 5.2 + 1.2 * std::sin(2 * place.turn + 0.6));
  const double armpit = 0.22 * gauss((place.along - 5.0) / 5.0) * smoothRamp(2.0, -6.0, p.y - 4.0) *
                        std::sin(1.25 * (m.x + 0.6 * m.y));
  return d + drape + elbow + armpit;
}

// Above 0 where there is cloth: above the hem, outside the collar, before the cuffs.
double kept(dvec3 p) {
  const Place place = placeOf(p);
  const double neck = p.y > 4 ? glm::length(dvec2(p.x, (p.z - kNeckMiddle.z) * 0.95)) - kNeck : 1e3;
  const double cuff = place.sleeve > 0.5 ? kCuff - place.along : 1e3;
  return std::min({p.y - kHem, neck, cuff});
}

dvec3 onto(dvec3 p) {
  for (int k = 0; k < 3; ++k) {
    const dvec3 slope = slopeOf(distance, p);
    p -= slope * (distance(p) / std::max(glm::dot(slope, slope), 0.2));
  }
  return p;
}

dvec3 trace(dvec3 from, dvec3 direction) {
  double t = 0;
  for (int step = 0; step < 200; ++step) {
    const double d = distance(from + t * direction);
    if (std::abs(d) < 1e-4) break;
    t += 0.6 * d;
  }
  return from + t * direction;
}

struct Part {
  SurfaceMesh mesh;
  std::vector<dvec3> colors;  // a point
  uint32_t material;
};

// Front, back and the two sleeves are charts of their own; sleeves are slit along their underside.
Part cloth() {
  const SurfaceNet net = surfaceNet(distance, {-70.4, -41.6, -16.0}, {70.4, 22.4, 16.0}, 1.0667);
  Part part;
  part.material = kCloth;
  part.mesh.points = net.points;
  std::vector<double> levels;
  for (const dvec3& p : net.points) levels.push_back(kept(p));
  for (size_t v = 0; v < levels.size(); ++v) {
    dvec3& p = part.mesh.points[v];
    // What stands over an edge is drawn back to it.
    for (int k = 0; k < 4 && levels[v] < 0.35 && kept(p) < 1e-3 + (levels[v] > 0 ? 10 : 0); ++k) {
      const dvec3 slope = slopeOf(kept, p);
      p = onto(p - slope * (kept(p) / std::max(glm::dot(slope, slope), 0.2)));
    }
  }
  std::map<std::array<int64_t, 3>, uint32_t> vertex_of;
  for (const auto& quad : net.quads) {
    if (std::ranges::none_of(quad, [&](uint32_t v) { return levels[v] >= 0.35; })) continue;
    dvec3 middle(0);
    for (uint32_t v : quad) middle += 0.25 * part.mesh.points[v];
    const Place centre = placeOf(middle);
    const bool sleeve = centre.sleeve > 0.5;
    const int chart = sleeve ? (centre.side > 0 ? 2 : 3) : (middle.z > -0.6 ? 0 : 1);
    std::array<uint32_t, 4> corners{};
    for (int k = 0; k < 4; ++k) {
      const dvec3 p = part.mesh.points[quad[k]];
      const Place place = placeOf(p);
      dvec2 uv;
      int64_t wrap = 0;
      if (sleeve) {
        // Cut at -90 degrees, under the arm.
        const auto fromCut = [](double turn) { return std::fmod(turn + 2.5 * kPi, 2 * kPi); };
        double turn = fromCut(place.turn);
        const double at = fromCut(centre.turn);
        if (turn - at > kPi) turn -= 2 * kPi, wrap = -1;
        if (at - turn > kPi) turn += 2 * kPi, wrap = 1;
        uv = {7.4 * turn, place.along + 9.0};
      } else {
        const double turn = std::atan2(p.x / 17.0, std::abs(p.z + 0.6) / 11.5 + 1e-9);
        uv = {15.5 * turn + 27.0, p.y - kHem + 1.0};
      }
      constexpr dvec2 kCorner[] = {{0, 0}, {60, 0}, {1.5, 62}, {61.5, 62}};
      const std::array<int64_t, 3> key{quad[k], chart, wrap};
      const auto [slot, fresh] = vertex_of.try_emplace(key, static_cast<uint32_t>(part.mesh.vertices.size()));
      if (fresh) part.mesh.addVertex(quad[k], glm::clamp((uv + kCorner[chart] + 2.0) / 126.0, 0.0, 1.0));
      corners[k] = slot->second;
    }
    const size_t before = part.mesh.triangles.size();
    part.mesh.addQuad(corners[0], corners[1], corners[2], corners[3]);
    // What lies along an edge, or was folded over on the way there.
    for (size_t t = part.mesh.triangles.size(); t-- > before;) {
      const auto& [a, b, c] = part.mesh.triangles[t].points;
      const std::vector<dvec3>& points = part.mesh.points;
      const bool on_edge = std::max({levels[a], levels[b], levels[c]}) < 0.35;
      const dvec3 normal = glm::cross(points[b] - points[a], points[c] - points[a]);
      if (on_edge || glm::dot(normal, slopeOf(distance, points[a])) <= 0.3 * glm::length(normal))
        part.mesh.triangles.erase(part.mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    }
  }
  for (const dvec3& p : part.mesh.points) {
    const Place place = placeOf(p);
    // Seams at the armhole, and wear.
    const double seam =
        gauss((armDistance({std::abs(p.x), p.y, p.z}) - torsoDistance({std::abs(p.x), p.y, p.z})) / 0.9) *
        smoothRamp(-8.0, -4.0, place.along);
    part.colors.push_back(dvec3(0.150, 0.165, 0.098) *
                          (1 + 0.06 * valueNoise(p * 0.4) + 0.04 * valueNoise(p * 1.4)) * (1 - 0.25 * seam));
  }
  return part;
}

struct Edge {
  std::vector<dvec3> points, away;  // closed; on the surface, and where the band goes from there
};

// A knitted band sewn to an edge, doubled over at its far end.
Part band(const Edge& edge, double width, double narrower) {
  // Along the band as a part of its width, and away from the edge's surface, as seen in a cut.
  constexpr dvec2 kProfile[] = {{-0.10, 0.06}, {-0.04, 0.30}, {0.06, 0.36}, {0.25, 0.34},
                                {0.5, 0.33},   {0.75, 0.33},  {0.93, 0.30}, {1.0, 0.12},
                                {0.97, -0.12}, {0.7, -0.22},  {0.3, -0.22}, {0.02, -0.2}};
  Part part;
  part.material = kKnit;
  const uint32_t spokes = static_cast<uint32_t>(edge.points.size());
  dvec3 middle(0);
  for (const dvec3& p : edge.points) middle += p / static_cast<double>(spokes);
  for (const dvec2 profile : kProfile) {
    for (uint32_t s = 0; s < spokes; ++s) {
      const dvec3 out = edge.points[s] - middle;
      const dvec3 outward = glm::normalize(out - edge.away[s] * glm::dot(out, edge.away[s]));
      const double rib = std::cos(kPi * s);
      const double taken_in = narrower * smoothRamp(0.0, 0.3, profile.x);
      part.mesh.points.push_back(
          edge.points[s] + edge.away[s] * (width * profile.x) +
          outward * (profile.y * 1.3 + 0.07 * rib * smoothRamp(0.0, 0.1, profile.x) - taken_in));
      part.colors.push_back(dvec3(0.040, 0.044, 0.036) * (1.0 + 0.28 * rib) * (profile.y < 0 ? 0.4 : 1.0));
    }
  }
  const uint32_t rings = std::size(kProfile);
  for (uint32_t ring = 0; ring < rings; ++ring)
    for (uint32_t s = 0; s <= spokes; ++s)
      part.mesh.addVertex(ring * spokes + s % spokes,
                          {0.01 + 0.98 * s / spokes, 0.01 + 0.98 * ring / (rings - 1)});
  for (uint32_t ring = 0; ring + 1 < rings; ++ring) {
    for (uint32_t s = 0; s < spokes; ++s) {
      const uint32_t a = ring * (spokes + 1) + s, b = a + spokes + 1;
      part.mesh.addQuad(a, a + 1, b + 1, b);
    }
  }
  return part;
}

Part mirrored(Part part) {
  for (dvec3& p : part.mesh.points) p.x = -p.x;
  for (SurfaceMesh::Triangle& triangle : part.mesh.triangles) {
    std::swap(triangle.points[1], triangle.points[2]);
    std::swap(triangle.vertices[1], triangle.vertices[2]);
  }
  return part;
}

Part zip() {
  Part part;
  part.material = kZip;
  constexpr uint32_t kDown = 76;
  constexpr dvec2 kAcross[] = {{-0.9, -0.1}, {-0.75, 0.2}, {-0.2, 0.24}, {0.0, 0.34},
                               {0.2, 0.24},  {0.75, 0.2},  {0.9, -0.1}};
  const uint32_t across = std::size(kAcross);
  for (uint32_t j = 0; j <= kDown; ++j) {
    for (const dvec2 a : kAcross) {
      const double y = glm::mix(kHem - 0.2, 13.0, static_cast<double>(j) / kDown);
      const dvec3 p = trace({0, y, 30}, {0, 0, -1});
      part.mesh.points.push_back(p + dvec3(a.x, 0, a.y));
      const bool metal = std::abs(a.x) < 0.1;
      part.colors.push_back(metal ? dvec3(j % 2 ? 0.42 : 0.16) : dvec3(0.030, 0.033, 0.028));
    }
  }
  for (uint32_t j = 0; j <= kDown; ++j)
    for (uint32_t i = 0; i < across; ++i)
      part.mesh.addVertex(j * across + i, {0.02 + 0.96 * i / (across - 1), 0.02 + 0.96 * j / kDown});
  for (uint32_t j = 0; j < kDown; ++j)
    for (uint32_t i = 0; i + 1 < across; ++i)
      part.mesh.addQuad(j * across + i, j * across + i + 1, (j + 1) * across + i + 1, (j + 1) * across + i);
  return part;
}

std::vector<Part> bands() {
  constexpr uint32_t kBody = 240, kSmall = 120;
  Edge hem, collar, cuff;
  for (uint32_t s = 0; s < kBody; ++s) {
    const double turn = 2 * kPi * s / kBody;
    const dvec3 out(std::sin(turn), 0, std::cos(turn));
    hem.points.push_back(trace(dvec3(0, kHem, 0) + 40.0 * out, -out));
    hem.away.emplace_back(0, -1, 0);
  }
  std::ranges::reverse(hem.points);
  for (uint32_t s = 0; s < kSmall; ++s) {
    const double turn = 2 * kPi * s / kSmall;
    const dvec3 p = kNeckMiddle + dvec3(kNeck * std::sin(turn), 40, kNeck * std::cos(turn) / 0.95);
    collar.points.push_back(trace(p, {0, -1, 0}));
    collar.away.push_back(glm::normalize(dvec3(-0.30 * std::sin(turn), 1, -0.15 - 0.20 * std::cos(turn))));
    const dvec3 over = glm::normalize(glm::cross(dvec3(0, 0, 1), kArm.fore)),
                forward = glm::cross(kArm.fore, over);
    const dvec3 out = std::cos(turn) * forward + std::sin(turn) * over;
    const dvec3 middle = kArm.elbow + (kCuff - kUpperLength) * kArm.fore;
    cuff.points.push_back(trace(middle + 15.0 * out, -out));
    cuff.away.push_back(kArm.fore);
  }
  Part left = band(cuff, 5.0, 1.6);
  return {band(hem, 5.0, 1.5), band(collar, 4.2, 0.0), left, mirrored(left), zip()};
}

struct Influence {
  glm::u8vec4 joints{0};
  glm::vec4 weights{0.0f};
};

Influence influenceOf(dvec3 p) {
  const Place place = placeOf(p);
  const double bend = smoothRamp(kUpperLength - 14.0, kUpperLength + 14.0, place.along) * place.sleeve;
  const double spine = smoothRamp(-33.0, -17.0, p.y), chest = smoothRamp(-17.0, 1.0, p.y);
  // From a joint at 0 by its helper to the next at 1.
  const auto first = [](double t) { return std::max(0.0, 1 - 2 * t); };
  const auto half = [](double t) { return 1 - std::abs(2 * t - 1); };
  const auto last = [](double t) { return std::max(0.0, 2 * t - 1); };
  // Over the shoulder the cloth gives way further than its seams reach.
  const dvec3 m(std::abs(p.x), p.y, p.z);
  const double arm_part =
      smoothRamp(9.0, -9.0, armDistance(m) - torsoDistance(m)) * smoothRamp(-13.0, 11.0, place.along);
  const double body = first(arm_part), limb = last(arm_part);
  const uint8_t arm = place.side > 0 ? 0 : kArmJoints;
  const auto joint = [&](Joint j) { return static_cast<uint8_t>(j + arm); };
  const double lifted = smoothRamp(4.5, 18.0, m.x) * smoothRamp(-4.0, 9.0, m.y);
  std::array<std::pair<double, uint8_t>, 8> all{{{body * (1 - spine), kHips},
                                                 {body * spine * (1 - chest), kSpine},
                                                 {body * spine * chest * (1 - lifted), kChest},
                                                 {body * spine * chest * lifted, joint(kClavicle)},
                                                 {half(arm_part), joint(kShoulderHalf)},
                                                 {limb * first(bend), joint(kUpperArm)},
                                                 {limb * half(bend), joint(kElbowHalf)},
                                                 {limb * last(bend), joint(kForeArm)}}};
  std::ranges::sort(all, std::greater());
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += all[k].first;
  Influence influence;
  for (int k = 0; k < 4; ++k) {
    influence.weights[k] = static_cast<float>(all[k].first / sum);
    influence.joints[k] = all[k].first > 0 ? all[k].second : uint8_t{0};
  }
  return influence;
}

// Unit, in the surface, if `wish` is not across it.
glm::vec3 tangent(dvec3 wish, dvec3 normal) {
  const dvec3 t = wish - normal * glm::dot(wish, normal);
  return glm::length(t) > 1e-3 ? glm::vec3(glm::normalize(t)) : glm::vec3(1, 0, 0);
}

void paint(Primitive& primitive, const std::vector<dvec3>& positions, const std::vector<dvec3>& normals) {
  std::vector<glm::vec4> mask_a, mask_b;
  std::vector<glm::vec3> along, around, twist_left, twist_right, bias;
  for (size_t v = 0; v < positions.size(); ++v) {
    const dvec3 p = positions[v], n = normals[v];
    const Place place = placeOf(p);
    const double body = 1 - place.sleeve;
    const dvec3 axis = place.axis * dvec3(place.side, 1, 1);
    const double elbow = place.sleeve * bump((place.along - kUpperLength) / 19.0);
    const double apart = armDistance({std::abs(p.x), p.y, p.z}) - torsoDistance({std::abs(p.x), p.y, p.z});
    const double shoulder = bump((place.along - 3.0) / 14.0) * smoothRamp(9.0, 2.0, apart);
    const double waist = body * bump((p.y + 19.0) / 17.0);
    const double gather = std::max(body * smoothRamp(kHem + 9.0, kHem + 1.5, p.y),
                                   place.sleeve * smoothRamp(kCuff - 8.0, kCuff - 1.5, place.along));
    mask_a.emplace_back(elbow, shoulder, waist, waist);
    mask_b.emplace_back(gather, 0, 0, 1);
    const dvec3 down = glm::mix(dvec3(0, -1, 0), axis, place.sleeve);
    along.push_back(tangent(down, n));
    around.push_back(tangent(glm::cross(n, down), n));
    twist_left.emplace_back(glm::normalize(along.back() + around.back()));
    twist_right.emplace_back(glm::normalize(along.back() - around.back()));
    // The cut of the shoulder never lies flat.
    const double rest = 0.30 * shoulder * (0.75 + 0.5 * valueNoise(p * 0.25)) + 0.10 * elbow;
    bias.emplace_back(static_cast<float>(0.5 + std::max(rest, 0.0)));
  }
  primitive.vec4_attributes = {{"_MASK_A", std::move(mask_a)}, {"_MASK_B", std::move(mask_b)}};
  primitive.vec3_attributes = {{"_DIR_ALONG", std::move(along)},
                               {"_DIR_AROUND", std::move(around)},
                               {"_DIR_TWIST_LEFT", std::move(twist_left)},
                               {"_DIR_TWIST_RIGHT", std::move(twist_right)},
                               {"_BIAS", std::move(bias)}};
}

Primitive finish(const Part& part) {
  const std::vector<dvec3> normals = pointNormals(part.mesh, part.mesh.points);
  Primitive primitive;
  primitive.material = part.material;
  std::vector<uint32_t> number(part.mesh.vertices.size(), ~0u);
  std::vector<dvec3> positions, vertex_normals;
  for (const SurfaceMesh::Triangle& triangle : part.mesh.triangles) {
    for (uint32_t v : triangle.vertices) {
      if (number[v] == ~0u) {
        number[v] = static_cast<uint32_t>(positions.size());
        const SurfaceMesh::Vertex& vertex = part.mesh.vertices[v];
        positions.push_back(part.mesh.points[vertex.point]);
        vertex_normals.push_back(normals[vertex.point]);
        primitive.positions.emplace_back(positions.back() * 0.01);
        primitive.normals.emplace_back(vertex_normals.back());
        primitive.uvs.emplace_back(vertex.uv.x, 1 - vertex.uv.y);
        primitive.colors.emplace_back(glm::vec3(part.colors[vertex.point]), 1.0f);
        const Influence influence = influenceOf(positions.back());
        primitive.joints.push_back(influence.joints);
        primitive.weights.push_back(influence.weights);
      }
      primitive.indices.push_back(number[v]);
    }
  }
  if (part.material == kCloth) paint(primitive, positions, vertex_normals);
  return primitive;
}

struct Turn {
  uint32_t node;
  glm::vec3 axis;
  double degrees;
};

// Every joint turned by its degrees times phase(t), t from 0 to 1.
template <class Phase>
Clip swing(std::string name, double seconds, const std::vector<Turn>& turns, Phase&& phase) {
  Clip clip;
  clip.name = std::move(name);
  for (const Turn& turn : turns) clip.rotations.push_back({turn.node, {}});
  const int keys = static_cast<int>(seconds * 30);
  for (int key = 0; key <= keys; ++key) {
    const double t = static_cast<double>(key) / keys;
    clip.times.push_back(static_cast<float>(t * seconds));
    for (size_t i = 0; i < turns.size(); ++i)
      clip.rotations[i].rotations.push_back(
          glm::angleAxis(static_cast<float>(glm::radians(turns[i].degrees * phase(t))), turns[i].axis));
  }
  return clip;
}

}  // namespace

Scene buildJacket() {
  Scene scene;
  scene.materials = {{"cloth", glm::vec3(1), 0.75f, true},
                     {"knit", glm::vec3(1), 0.9f, true},
                     {"zip", glm::vec3(1), 0.4f, true}};
  const auto metres = [](dvec3 p) { return glm::vec3(p * 0.01); };
  const dvec3 hips(0, -36, 0), spine(0, -24, -1), chest(0, -8, -1), mirror(-1, 1, 1);
  scene.nodes = {{"Rig", -1, {}},
                 {"hips", 0, metres(hips)},
                 {"spine", 1, metres(spine - hips)},
                 {"chest", 2, metres(chest - spine)},
                 {"collarboneLeft", 3, metres(kCollarbone - chest)},
                 {"shoulderLeft", 4, metres(kShoulder - kCollarbone)},
                 {"upperArmLeft", 4, metres(kShoulder - kCollarbone)},
                 {"elbowLeft", 6, metres(kArm.elbow - kShoulder)},
                 {"foreArmLeft", 6, metres(kArm.elbow - kShoulder)},
                 {"collarboneRight", 3, metres(kCollarbone * mirror - chest)},
                 {"shoulderRight", 9, metres((kShoulder - kCollarbone) * mirror)},
                 {"upperArmRight", 9, metres((kShoulder - kCollarbone) * mirror)},
                 {"elbowRight", 11, metres((kArm.elbow - kShoulder) * mirror)},
                 {"foreArmRight", 11, metres((kArm.elbow - kShoulder) * mirror)},
                 {"Jacket", -1, {}, 0, true}};
  scene.joints = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};
  Mesh jacket;
  jacket.name = "Jacket";
  jacket.primitives.push_back(finish(cloth()));
  for (const Part& part : bands()) jacket.primitives.push_back(finish(part));
  scene.meshes = {std::move(jacket)};

  const glm::vec3 elbow = glm::normalize(glm::vec3(glm::cross(kArm.fore, dvec3(-0.2, 0.55, 0.8))));
  const glm::vec3 elbow_right = elbow * glm::vec3(1, -1, -1);
  const auto outAndBack = [](double t) { return 0.5 - 0.5 * std::cos(2 * kPi * t); };
  const auto toBothSides = [](double t) { return std::sin(2 * kPi * t); };
  // Up, and then down to the sides.
  const auto upAndDown = [](double t) {
    return t < 0.6 ? std::sin(kPi * t / 0.6) : -0.42 * std::sin(kPi * (t - 0.6) / 0.4);
  };
  scene.clips = {
      swing("bend", 2.0, {{7, elbow, 42.5}, {8, elbow, 85}, {12, elbow_right, 42.5}, {13, elbow_right, 85}},
            outAndBack),
      swing("raise", 3.0,
            {{4, {0, 0, 1}, 22},
             {5, {0, 0, 1}, 29},
             {6, {0, 0, 1}, 58},
             {9, {0, 0, 1}, -22},
             {10, {0, 0, 1}, -29},
             {11, {0, 0, 1}, -58}},
            upAndDown),
      swing("twist", 3.0, {{2, {0, 1, 0}, 22}, {3, {0, 1, 0}, 22}}, toBothSides),
      swing("lean", 2.0, {{2, {1, 0, 0}, 24}, {3, {1, 0, 0}, 20}}, outAndBack),
      swing("sway", 3.0, {{2, {0, 0, 1}, 15}, {3, {0, 0, 1}, 15}}, toBothSides)};
  return scene;
}

}  // namespace furrow::content
