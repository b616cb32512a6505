#include "pipeline/import/sequence.h"

#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <glm/geometric.hpp>

#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/import/import.h"

namespace furrow::pipeline {
namespace {

constexpr size_t kMostFrames = 2048;  // the clip has frames^2 weights
constexpr size_t kMostVertices = size_t{1} << 26;

// Runs of digits by their value, all else by its letters.
bool naturalLess(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  for (size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (!digit(a[i]) || !digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    while (i + 1 < a.size() && a[i] == '0' && digit(a[i + 1])) ++i;
    while (j + 1 < b.size() && b[j] == '0' && digit(b[j + 1])) ++j;
    size_t m = i, n = j;
    while (m < a.size() && digit(a[m])) ++m;
    while (n < b.size() && digit(b[n])) ++n;
    if (m - i != n - j) return m - i < n - j;
    if (const int order = a.compare(i, m - i, b, j, n - j); order != 0) return order < 0;
    i = m, j = n;
  }
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

// Area-weighted, unit; zero where no face gives one.
std::vector<glm::vec3> normalsOf(const Polygons& mesh) {
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
  for (size_t f = 0, begin = 0; f < mesh.ends.size(); begin = mesh.ends[f++]) {
    const glm::dvec3 first = mesh.positions[mesh.corners[begin]];
    glm::dvec3 normal(0.0);
    for (size_t i = begin + 1; i + 1 < mesh.ends[f]; ++i)
      normal += glm::cross(glm::dvec3(mesh.positions[mesh.corners[i]]) - first,
                           glm::dvec3(mesh.positions[mesh.corners[i + 1]]) - first);
    for (size_t i = begin; i < mesh.ends[f]; ++i) sums[mesh.corners[i]] += normal;
  }
  std::vector<glm::vec3> normals;
  for (const glm::dvec3& sum : sums) {
    const double length = glm::length(sum);
    normals.push_back(length > 0.0 ? glm::vec3(sum / length) : glm::vec3(0.0f));
  }
  return normals;
}

// Mean of the corners.
glm::dvec3 centre(const Polygons& mesh) {
  glm::dvec3 sum(0.0);
  for (const uint32_t v : mesh.corners) sum += mesh.positions[v];
  return sum / static_cast<double>(mesh.corners.size());
}

double radius(const Polygons& mesh, const glm::dvec3& about) {
  double most = 0.0;
  for (const uint32_t v : mesh.corners)
    most = std::max(most, glm::distance(glm::dvec3(mesh.positions[v]), about));
  return most;
}

void checkSame(const Polygons& base, const std::filesystem::path& base_file, const Polygons& frame,
               const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& what) {
    throw Error(Exit::kBadData, file.string(), what, "export all frames from one mesh");
  };
  const std::string other = " and " + base_file.filename().string() + " has ";
  if (frame.positions.size() != base.positions.size())
    refuse("it has " + std::to_string(frame.positions.size()) + " vertices" + other +
           std::to_string(base.positions.size()));
  if (frame.ends.size() != base.ends.size())
    refuse("it has " + std::to_string(frame.ends.size()) + " faces" + other +
           std::to_string(base.ends.size()));
  for (size_t f = 0, begin = 0; f < base.ends.size(); begin = base.ends[f++])
    if (frame.ends[f] != base.ends[f] ||
        !std::equal(&base.corners[begin], &base.corners[begin] + (base.ends[f] - begin),
                    &frame.corners[begin]))
      refuse("its face " + std::to_string(f + 1) + " joins other vertices than that of " +
             base_file.filename().string());
}

}  // namespace

std::vector<std::filesystem::path> sequenceFiles(const std::filesystem::path& pattern) {
  const std::filesystem::path folder = pattern.parent_path();
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, error)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file(error) && ::fnmatch(pattern.filename().c_str(), name.c_str(), FNM_PERIOD) == 0)
      names.push_back(name);
  }
  std::sort(names.begin(), names.end(), naturalLess);
  std::vector<std::filesystem::path> files;
  for (const std::string& name : names) files.push_back(folder / name);
  return files;
}

SourceScene importSequence(const Sequence& sequence) {
  const auto refuse = [&](const std::string& what, const char* remedy) {
    throw Error(Exit::kBadData, sequence.pattern.string(), what, remedy);
  };
  const std::vector<std::filesystem::path> files = sequenceFiles(sequence.pattern);
  if (files.empty()) refuse("no file has such a name", "quote the pattern: --sequence 'frame_*.obj'");
  if (files.size() > kMostFrames)
    refuse("it is " + std::to_string(files.size()) + " frames", "cook at most 2048 of them");

  const std::filesystem::path& base_file = sequence.base.empty() ? files.front() : sequence.base;
  const Polygons base = importPolygons(base_file);
  SourceScene scene = import(base_file);
  scene.sequence = true;
  size_t vertices = 0;
  for (const Primitive& primitive : scene.primitives) vertices += primitive.positions.size();
  if (files.size() > kMostVertices / vertices)
    refuse("its frames have more than 2^26 vertices together", "cook fewer frames or a coarser mesh");
  const std::vector<glm::vec3> base_normals = normalsOf(base);
  const glm::dvec3 base_centre = centre(base);
  const double size = 2.0 * radius(base, base_centre);

  Channel weights{.path = ChannelPath::kWeights, .times = {}, .values = {}};
  Channel travel{.path = ChannelPath::kTranslation, .times = {}, .values = {}};
  weights.values.assign(files.size() * files.size(), 0.0f);
  bool travels = false;
  for (uint32_t f = 0; f < files.size(); ++f) {
    const Polygons frame = importPolygons(files[f]);
    checkSame(base, base_file, frame, files[f]);
    if (std::find(scene.dependencies.begin(), scene.dependencies.end(), files[f]) == scene.dependencies.end())
      scene.dependencies.push_back(files[f]);
    const float time = static_cast<float>(f / sequence.fps);
    weights.times.push_back(time);
    weights.values[f * files.size() + f] = 1.0f;
    glm::vec3 shift = centre(frame) - base_centre;
    if (glm::length(shift) <= size) shift = glm::vec3(0.0f);
    travels |= shift != glm::vec3(0.0f);
    travel.times.push_back(time);
    travel.values.insert(travel.values.end(), {shift.x, shift.y, shift.z});

    const std::vector<glm::vec3> normals = normalsOf(frame);
    scene.rig.morphs.push_back({.name = files[f].stem().string(), .node = 0, .index = f});
    for (Primitive& primitive : scene.primitives) {
      MorphDelta& delta = primitive.morphs.emplace_back();
      for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
        const uint32_t place = primitive.file_vertices[v];
        const glm::vec3 moved =
            glm::dvec3(frame.positions[place]) - glm::dvec3(primitive.positions[v]) - glm::dvec3(shift);
        if (moved == glm::vec3(0.0f) && normals[place] == base_normals[place]) continue;
        delta.vertices.push_back(v);
        delta.positions.push_back(moved);
        delta.normals.push_back(normals[place] - base_normals[place]);
      }
    }
  }
  Clip clip{.name = "sequence", .duration = weights.times.back(), .channels = {std::move(weights)}};
  if (travels) clip.channels.push_back(std::move(travel));
  scene.rig.clips.push_back(std::move(clip));
  return scene;
}

}  // namespace furrow::pipeline
