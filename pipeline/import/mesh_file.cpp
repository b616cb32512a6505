#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <istream>
#include <map>
#include <mutex>
#include <span>
#include <sstream>
#include <streambuf>
#include <string_view>

#include "pipeline/import/formats.h"
#include "pipeline/import/obj_materials.h"
#include "pipeline/import/simple_ply.h"

// The readers register themselves from this header.
#include <OpenMesh/Core/IO/MeshIO.hh>

namespace furrow::pipeline {
namespace {

// Corners that may be looked at to cut the ears of a file's polygons, which takes at least the square of a
// polygon's corners; what is left then becomes a fan.
constexpr size_t kEarEffort = size_t{1} << 27;

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

// Where an OBJ file changes its material: lines behind `offset` use `name`.
struct MaterialChange {
  std::streamoff offset = 0;
  std::string name;
};

// What OpenMesh's readers are not asked.
struct Notes {
  std::vector<MaterialChange> changes;
  std::vector<std::string> libraries;  // what stands behind every "mtllib" of an OBJ file
  std::vector<std::string> textures;   // image files that a PLY file names
  size_t vertices = 0;                 // that an OBJ file means to have
};

// Takes down what OpenMesh's readers find, corner by corner, without building a half-edge mesh, so that
// non-manifold faces stay and UV and normal seams split vertices. An OBJ reader sets the UV and normal of a
// face's corners just before it adds the face.
class Recorder final : public OpenMesh::IO::BaseImporter {
 public:
  using VertexHandle = OpenMesh::VertexHandle;
  using FaceHandle = OpenMesh::FaceHandle;
  using HalfedgeHandle = OpenMesh::HalfedgeHandle;
  using EdgeHandle = OpenMesh::EdgeHandle;

  // A corner: a place, and the UV and normal it has there.
  struct Corner {
    uint32_t place = 0;
    glm::vec2 uv{0.0f};
    glm::vec3 normal{0.0f};
    uint32_t next = kNoIndex;  // another corner at this place
  };

  // `corner_uvs`: u and v of the corners of all faces, or empty.
  Recorder(std::streambuf& stream, Notes notes, std::span<const float> corner_uvs)
      : has_uvs(!corner_uvs.empty()), stream_(stream), notes_(std::move(notes)), corner_uvs_(corner_uvs) {}

  std::vector<glm::vec3> positions;
  std::vector<glm::vec4> colors;  // as long as positions if has_colors
  std::vector<Corner> corners;
  std::vector<uint32_t> polygon_corners;
  std::vector<uint32_t> polygon_ends;       // in polygon_corners
  std::vector<uint32_t> polygon_materials;  // index into the changes + 1; 0 before the first
  bool has_uvs = false, has_normals = false, has_colors = false;
  size_t faces_without_area = 0;

  const Notes& notes() const { return notes_; }
  uint32_t firstCorner(uint32_t place) const { return places_[place].first; }

  VertexHandle add_vertex(const OpenMesh::Vec3f& p) override {
    positions.emplace_back(p[0], p[1], p[2]);
    places_.emplace_back();
    if (has_colors) colors.emplace_back(1.0f);
    return VertexHandle(static_cast<int>(positions.size() - 1));
  }
  VertexHandle add_vertex() override { return add_vertex(OpenMesh::Vec3f(0.0f, 0.0f, 0.0f)); }
  void set_point(VertexHandle v, const OpenMesh::Vec3f& p) override {
    positions[checked(v)] = {p[0], p[1], p[2]};
  }
  void set_normal(VertexHandle v, const OpenMesh::Vec3f& n) override {
    has_normals = true;
    places_[checked(v)].normal = {n[0], n[1], n[2]};
  }
  void set_normal(VertexHandle v, const OpenMesh::Vec3d& n) override { set_normal(v, OpenMesh::Vec3f(n)); }
  void set_texcoord(VertexHandle v, const OpenMesh::Vec2f& t) override {
    has_uvs = true;
    places_[checked(v)].uv = {t[0], t[1]};
  }
  void set_color(VertexHandle v, const OpenMesh::Vec4f& c) override { setColor(v, {c[0], c[1], c[2], c[3]}); }
  void set_color(VertexHandle v, const OpenMesh::Vec3f& c) override { setColor(v, {c[0], c[1], c[2], 1.0f}); }
  void set_color(VertexHandle v, const OpenMesh::Vec4uc& c) override {
    setColor(v, glm::vec4(c[0], c[1], c[2], c[3]) / 255.0f);
  }
  void set_color(VertexHandle v, const OpenMesh::Vec3uc& c) override {
    setColor(v, glm::vec4(c[0], c[1], c[2], 255.0f) / 255.0f);
  }

  FaceHandle add_face(const VHandles& vertices) override {
    if (positions.size() < notes_.vertices)
      fail(std::to_string(notes_.vertices - positions.size()) + " vertices are not three numbers");
    const std::span<const float> uvs = corner_uvs_.first(std::min(2 * vertices.size(), corner_uvs_.size()));
    corner_uvs_ = corner_uvs_.subspan(uvs.size());
    if (vertices.size() < 3) {
      ++faces_without_area;
      return FaceHandle();
    }
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (2 * i + 1 < uvs.size()) set_texcoord(vertices[i], {uvs[2 * i], uvs[2 * i + 1]});
      polygon_corners.push_back(corner(checked(vertices[i])));
    }
    polygon_ends.push_back(static_cast<uint32_t>(polygon_corners.size()));
    // The stream stands behind the line that holds the face.
    const std::streamoff at = stream_.pubseekoff(0, std::ios::cur, std::ios::in);
    while (change_ < notes_.changes.size() && notes_.changes[change_].offset < at) ++change_;
    polygon_materials.push_back(static_cast<uint32_t>(change_));
    return FaceHandle(static_cast<int>(polygon_ends.size() - 1));
  }

  size_t n_vertices() const override { return positions.size(); }
  size_t n_faces() const override { return polygon_ends.size(); }
  size_t n_edges() const override { return 0; }

  // What furrow does not use.
  HalfedgeHandle add_edge(VertexHandle, VertexHandle) override { return HalfedgeHandle(); }
  FaceHandle add_face(HalfedgeHandle) override { return FaceHandle(); }
  void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<OpenMesh::Vec2f>&) override {}
  void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<OpenMesh::Vec3f>&) override {}
  void set_face_texindex(FaceHandle, int) override {}
  void set_halfedge(VertexHandle, HalfedgeHandle) override {}
  void set_status(VertexHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_next(HalfedgeHandle, HalfedgeHandle) override {}
  void set_face(HalfedgeHandle, FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(HalfedgeHandle, const OpenMesh::Vec2f&) override {}
  void set_texcoord(VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_texcoord(HalfedgeHandle, const OpenMesh::Vec3f&) override {}
  void set_status(HalfedgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec3f&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec4f&) override {}
  void set_status(EdgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_normal(FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(FaceHandle, const OpenMesh::Vec3d&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec4f&) override {}
  void set_status(FaceHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void add_texture_information(int, std::string) override {}

 private:
  struct Place {
    glm::vec2 uv{0.0f};
    glm::vec3 normal{0.0f};
    uint32_t first = kNoIndex, last = kNoIndex;  // its corners
  };

  size_t checked(VertexHandle v) const {
    if (v.idx() < 0 || static_cast<size_t>(v.idx()) >= positions.size())
      fail("a face has a corner that does not exist: vertex " + std::to_string(v.idx()) + " of " +
           std::to_string(positions.size()));
    return static_cast<size_t>(v.idx());
  }

  void setColor(VertexHandle v, const glm::vec4& color) {
    if (!has_colors) colors.assign(positions.size(), glm::vec4(1.0f));
    has_colors = true;
    colors[checked(v)] = color;
  }

  uint32_t corner(size_t index) {
    Place& place = places_[index];
    for (uint32_t c = place.first; c != kNoIndex; c = corners[c].next)
      if (std::memcmp(&corners[c].uv, &place.uv, sizeof place.uv) == 0 &&
          std::memcmp(&corners[c].normal, &place.normal, sizeof place.normal) == 0)
        return c;
    const uint32_t added = static_cast<uint32_t>(corners.size());
    corners.push_back({static_cast<uint32_t>(index), place.uv, place.normal});
    (place.last == kNoIndex ? place.first : corners[place.last].next) = added;
    place.last = added;
    return added;
  }

  std::streambuf& stream_;
  Notes notes_;
  std::span<const float> corner_uvs_;  // of the faces to come
  std::vector<Place> places_;
  size_t change_ = 0;
};

// The bytes of a file as a stream that can be rewound.
class MemoryBuffer final : public std::streambuf {
 public:
  explicit MemoryBuffer(std::vector<uint8_t>& bytes) {
    char* begin = reinterpret_cast<char*>(bytes.data());
    setg(begin, begin, begin + bytes.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode) override {
    const off_type base = from == std::ios::beg   ? 0
                          : from == std::ios::cur ? gptr() - eback()
                                                  : egptr() - eback();
    return seekpos(base + offset, std::ios::in);
  }
  pos_type seekpos(pos_type position, std::ios::openmode) override {
    const off_type offset = position;
    if (offset < 0 || offset > egptr() - eback()) return pos_type(off_type(-1));
    setg(eback(), eback() + offset, egptr());
    return position;
  }
};

std::string_view trimmed(std::string_view text) {
  constexpr const char* kSpace = " \t\r\n";
  const size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

// Takes its notes of an OBJ file, and changes what OpenMesh's reader cannot bear: continued lines, UVs of one
// number, corners without a vertex, material files (it would look for them in the working directory).
Notes prepareObj(std::vector<uint8_t>& bytes) {
  for (size_t i = 0; i + 1 < bytes.size(); ++i) {
    if (bytes[i] != '\\') continue;
    const size_t line_feed = bytes[i + 1] == '\r' ? i + 2 : i + 1;
    if (line_feed < bytes.size() && bytes[line_feed] == '\n')
      std::fill_n(bytes.begin() + static_cast<ptrdiff_t>(i), line_feed + 1 - i, uint8_t{' '});
  }
  if (constexpr uint8_t kMark[] = {0xEF, 0xBB, 0xBF};
      bytes.size() > 3 && std::equal(kMark, kMark + 3, bytes.begin()))
    std::fill_n(bytes.begin(), 3, uint8_t{' '});
  if (std::find(bytes.begin(), bytes.end(), '\n') == bytes.end())
    std::replace(bytes.begin(), bytes.end(), uint8_t{'\r'}, uint8_t{'\n'});
  char* text = reinterpret_cast<char*>(bytes.data());
  constexpr std::string_view kZero = " 0";
  std::vector<size_t> lone;  // where a UV's v is missing
  Notes notes;
  for (size_t begin = 0; begin < bytes.size();) {
    const void* found = std::memchr(text + begin, '\n', bytes.size() - begin);
    const size_t end = found ? static_cast<size_t>(static_cast<const char*>(found) - text) : bytes.size();
    const std::string_view line = trimmed({text + begin, end - begin});
    const size_t word_end = std::min(line.find_first_of(" \t"), line.size());
    const std::string_view word = line.substr(0, word_end);
    const std::string_view rest = trimmed(line.substr(word_end));
    if (word == "v") {
      ++notes.vertices;
    } else if (word == "usemtl") {
      notes.changes.push_back(
          {static_cast<std::streamoff>(begin + kZero.size() * lone.size()), std::string(rest)});
    } else if (word == "vt") {
      const std::string_view u = rest.substr(0, rest.find_first_of(" \t#"));
      const std::string_view more = trimmed(rest.substr(u.size()));
      if (!u.empty() && (more.empty() || more.front() == '#'))
        lone.push_back(static_cast<size_t>(u.data() + u.size() - text));
    } else if (word == "mtllib") {
      notes.libraries.emplace_back(rest);
      text[line.data() - text] = '#';
    } else if (word == "f") {
      for (size_t i = 0; i < rest.size(); ++i)
        if (rest[i] == '/' && (i == 0 || std::isspace(static_cast<unsigned char>(rest[i - 1]))))
          fail("a face has a corner without a vertex");
    }
    begin = end + 1;
  }
  if (!lone.empty()) {
    std::vector<uint8_t> whole;
    whole.reserve(bytes.size() + kZero.size() * lone.size());
    size_t copied = 0;
    const auto copy = [&](size_t end) {
      whole.insert(whole.end(), text + copied, text + end);
      copied = end;
    };
    for (const size_t at : lone) {
      copy(at);
      whole.insert(whole.end(), kZero.begin(), kZero.end());
    }
    copy(bytes.size());
    bytes = std::move(whole);
  }
  return notes;
}

// Changes in place what OpenMesh's reader cannot bear in OFF text: comments, counts behind the keyword,
// without one or incomplete, colours of faces.
void prepareOff(std::vector<uint8_t>& bytes) {
  size_t start = 0;
  while (start < bytes.size() && !std::isalnum(bytes[start])) {
    const auto from = bytes.begin() + static_cast<ptrdiff_t>(start);
    start = bytes[start] == '#' ? static_cast<size_t>(std::find(from, bytes.end(), '\n') - bytes.begin())
                                : start + 1;
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(start));
  constexpr std::string_view kKeyword = "OFF\n";
  const auto line_end = std::find(bytes.begin(), bytes.end(), '\n');
  if (std::find(bytes.begin(), line_end, 'F') == line_end)
    bytes.insert(bytes.begin(), kKeyword.begin(), kKeyword.end());
  char* text = reinterpret_cast<char*>(bytes.data());
  size_t lines = 0, vertices = 0, rows = 0;
  ptrdiff_t counts = 0;
  for (size_t begin = 0; begin < bytes.size();) {
    const void* found = std::memchr(text + begin, '\n', bytes.size() - begin);
    size_t end = found ? static_cast<size_t>(static_cast<const char*>(found) - text) : bytes.size();
    const size_t comment = std::min(std::string_view(text + begin, end - begin).find('#'), end - begin);
    std::fill(text + begin + comment, text + end, ' ');
    const std::string_view line = trimmed({text + begin, end - begin});
    std::istringstream words{std::string(line)};
    if (line.empty()) {
      std::fill(text + begin, text + end, ' ');
    } else if (lines++ == 0) {
      if (line.find("BINARY") != line.npos) fail("it is binary OFF; furrow reads OFF as text");
      if (line.starts_with('n') || line.starts_with("4n")) fail("it is OFF of any dimension (nOFF)");
      const size_t space = line.find_first_of(" \t");
      if (space != std::string_view::npos) {
        end = static_cast<size_t>(line.data() - text) + space;
        text[end] = '\n';
      }
    } else if (counts < 3) {
      // Of vertices, faces and edges, on one line or several.
      const auto numbers = std::distance(std::istream_iterator<std::string>(words), {});
      if (counts == 0) std::from_chars(line.data(), line.data() + line.size(), vertices);
      if (counts == 2 && numbers > 1) {  // it is the first vertex, and the edges are left out
        const std::string_view zero = "0\n";
        bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(begin), zero.begin(), zero.end());
        text = reinterpret_cast<char*>(bytes.data());
        end += zero.size();
        counts = 3;
        rows = 1;
      } else {
        counts += numbers;
      }
    } else if (++rows > vertices) {
      size_t corners = 0;
      words >> corners;
      std::string corner;
      while (corners > 0 && words >> corner) --corners;
      if (const auto at = words.tellg(); at >= 0)
        std::fill(text + (line.data() - text) + static_cast<ptrdiff_t>(at), text + end, ' ');
    }
    begin = end + 1;
  }
}

bool isThreeNumbers(std::string_view text) {
  for (int i = 0; i < 3; ++i) {
    text = trimmed(text);
    if (text.starts_with('+')) text.remove_prefix(1);
    float number = 0.0f;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc::invalid_argument || !std::isfinite(number)) return false;
    text.remove_prefix(static_cast<size_t>(stop - text.data()));
  }
  return true;
}

// Refuses STL text that OpenMesh's reader would take in part: cut off, or with facets that are no triangles.
void checkStl(std::vector<uint8_t>& bytes) {
  if (std::find(bytes.begin(), bytes.end(), '\n') == bytes.end())
    std::replace(bytes.begin(), bytes.end(), uint8_t{'\r'}, uint8_t{'\n'});
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  size_t vertices = 0;
  bool facet = false, any = false, ended = false;
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('\n'), rest.size() - 1);
    const std::string_view line = trimmed(rest.substr(0, end + 1));
    rest.remove_prefix(end + 1);
    std::string word(line.substr(0, line.find_first_of(" \t")));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
    if (word.empty()) continue;
    if (word == "facet") {
      vertices = 0;
      facet = any = true;
      ended = false;
    } else if (word == "endsolid") {
      ended = true;
    } else if (word == "vertex") {
      ++vertices;
      if (!isThreeNumbers(line.substr(word.size()))) fail("a vertex is not three numbers");
    } else if (word == "endfacet") {
      if (facet && vertices != 3) fail("a facet has " + std::to_string(vertices) + " vertices, not three");
      facet = false;
    }
  }
  if (any && !ended) fail("cut off: it does not end with \"endsolid\"");
}

const char* extensionOf(MeshFormat format) {
  switch (format) {
    case MeshFormat::kObj:
      return ".obj";
    case MeshFormat::kPly:
      return ".ply";
    case MeshFormat::kOff:
      return ".off";
    default:
      return ".stl";
  }
}

void parse(MeshFormat format, MemoryBuffer& buffer, Recorder& recorder) {
  using OpenMesh::IO::Options;
  // The readers are single objects with state.
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  ::omerr().disable();
  ::omlog().disable();
  ::omout().disable();

  std::istream in(&buffer);
  // Their loops run to the counts of the file, not to its end: let it end them. The readers that go line by
  // line do stop at the end.
  if (format == MeshFormat::kPly || format == MeshFormat::kOff || format == MeshFormat::kStlBinary)
    in.exceptions(std::ios::failbit | std::ios::badbit);
  Options options =
      Options::VertexNormal | Options::VertexTexCoord | Options::VertexColor | Options::ColorAlpha;
  if (format == MeshFormat::kStlBinary) options += Options::Binary;
  bool read = false;
  try {
    read = OpenMesh::IO::IOManager().read(in, extensionOf(format), recorder, options);
  } catch (const std::ios::failure&) {
    fail("cut off, or a number in it is damaged");
  }
  if (!read) fail("its data is damaged");
}

glm::dvec3 newell(std::span<const glm::dvec3> points) {
  glm::dvec3 normal(0.0);
  for (size_t i = 0; i < points.size(); ++i) normal += glm::cross(points[i], points[(i + 1) % points.size()]);
  return normal;
}

bool isEar(const std::vector<glm::dvec3>& points, const std::vector<uint32_t>& left, size_t i,
           const glm::dvec3& normal, size_t& effort) {
  ++effort;
  const size_t n = left.size();
  const size_t before = (i + n - 1) % n, behind = (i + 1) % n;
  const glm::dvec3 &a = points[left[before]], &b = points[left[i]], &c = points[left[behind]];
  const auto side = [&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
    return glm::dot(glm::cross(q - p, r - p), normal);
  };
  if (side(a, b, c) <= 0.0) return false;
  for (size_t j = 0; j < n; ++j) {
    if (j == before || j == i || j == behind) continue;
    ++effort;
    const glm::dvec3& p = points[left[j]];
    if (side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0) return false;
  }
  return true;
}

// Triangles of a polygon as triples of its corners: a fan if it is convex, else ears. False if it is not
// convex and `effort` ran out.
bool triangulate(const std::vector<glm::dvec3>& points, std::vector<std::array<uint32_t, 3>>& out,
                 size_t& effort) {
  out.clear();
  const uint32_t n = static_cast<uint32_t>(points.size());
  std::vector<uint32_t> left(n);
  for (uint32_t i = 0; i < n; ++i) left[i] = i;
  bool cut = true;
  if (n > 3) {
    const glm::dvec3 normal = newell(points);
    bool convex = true;
    for (uint32_t i = 0; i < n && convex; ++i)
      convex = glm::dot(glm::cross(points[(i + 1) % n] - points[i], points[(i + 2) % n] - points[i]),
                        normal) >= 0.0;
    while (!convex && left.size() > 3) {
      size_t ear = 0;
      while (ear < left.size() && effort < kEarEffort && !isEar(points, left, ear, normal, effort)) ++ear;
      cut = effort < kEarEffort;
      if (ear == left.size() || !cut) break;
      const size_t m = left.size();
      out.push_back({left[(ear + m - 1) % m], left[ear], left[(ear + 1) % m]});
      left.erase(left.begin() + static_cast<ptrdiff_t>(ear));
    }
  }
  for (size_t i = 1; i + 1 < left.size(); ++i) out.push_back({left[0], left[i], left[i + 1]});
  return cut;
}

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Vertices of the primitive: all corners of a place together, places in file order. `wanted`: the corners in
// it, ascending by place.
Primitive makePrimitive(const Recorder& mesh, const std::vector<uint32_t>& wanted) {
  Primitive out;
  Attribute color{"COLOR_0", 4, {}};
  for (const uint32_t c : wanted) {
    const Recorder::Corner& corner = mesh.corners[c];
    out.positions.push_back(mesh.positions[corner.place]);
    out.file_vertices.push_back(corner.place);
    if (mesh.has_normals) out.normals.push_back(finite(corner.normal) ? corner.normal : glm::vec3(0.0f));
    // Images begin at the bottom for these formats, at the top for glTF.
    if (mesh.has_uvs)
      out.uvs.push_back(std::isfinite(corner.uv.x) && std::isfinite(corner.uv.y)
                            ? glm::vec2(corner.uv.x, 1.0f - corner.uv.y)
                            : glm::vec2(0.0f));
    if (mesh.has_colors)
      for (int k = 0; k < 4; ++k) {
        const float value = mesh.colors[corner.place][k];
        color.values.push_back(std::isfinite(value) ? value : 0.0f);
      }
  }
  if (mesh.has_colors) out.attributes.push_back(std::move(color));
  return out;
}

// Puts the image that a PLY file names onto what has no material.
void showTextures(const std::filesystem::path& file, const std::vector<std::string>& names,
                  ObjMaterials& obj) {
  if (names.size() == 1) {
    obj.materials[""].maps.color.image = 0;
    obj.images.push_back({names[0], findFile(names[0], {file.parent_path()}), {}});
  } else if (!names.empty()) {
    obj.warnings.push_back("its colours are in " + std::to_string(names.size()) + " textures, \"" + names[0] +
                           "\" and others, of which furrow shows none: export it as OBJ or glTF");
  }
}

Recorder record(MeshFormat format, std::vector<uint8_t>& bytes) {
  Notes notes;
  if (format == MeshFormat::kObj) notes = prepareObj(bytes);
  std::vector<float> corner_uvs;
  if (format == MeshFormat::kPly) {
    SimplePly ply = simplePly(bytes);
    bytes = std::move(ply.bytes);
    corner_uvs = std::move(ply.corner_uvs);
    notes.textures = std::move(ply.textures);
  }
  if (format == MeshFormat::kOff) prepareOff(bytes);
  if (format == MeshFormat::kStlText) checkStl(bytes);
  MemoryBuffer buffer(bytes);
  Recorder mesh(buffer, std::move(notes), corner_uvs);
  parse(format, buffer, mesh);
  if (mesh.polygon_ends.empty()) fail("it has no faces");
  return mesh;
}

}  // namespace

Polygons polygonsOf(MeshFormat format, std::vector<uint8_t> bytes) {
  Recorder mesh = record(format, bytes);
  Polygons out{std::move(mesh.positions), std::move(mesh.polygon_corners), std::move(mesh.polygon_ends)};
  for (uint32_t& corner : out.corners) {
    corner = mesh.corners[corner].place;
    if (!finite(out.positions[corner])) fail("a position is not finite");
  }
  return out;
}

std::vector<std::filesystem::path> meshFiles(const std::filesystem::path& file, MeshFormat format,
                                             std::vector<uint8_t> bytes) {
  ObjMaterials obj;
  if (format == MeshFormat::kObj) obj = readObjMaterials(file, prepareObj(bytes).libraries);
  if (format == MeshFormat::kPly) showTextures(file, plyTextures(bytes), obj);
  for (SourceImage& image : obj.images)
    if (std::filesystem::is_regular_file(image.file)) obj.files.push_back(std::move(image.file));
  return obj.files;
}

SourceScene importMeshFile(const std::filesystem::path& file, MeshFormat format, std::vector<uint8_t> bytes) {
  const Recorder mesh = record(format, bytes);

  SourceScene scene;
  scene.dependencies.push_back(file);
  ObjMaterials obj = readObjMaterials(file, mesh.notes().libraries);
  showTextures(file, mesh.notes().textures, obj);
  scene.images = std::move(obj.images);
  scene.warnings = std::move(obj.warnings);
  scene.dependencies.insert(scene.dependencies.end(), obj.files.begin(), obj.files.end());
  // Materials by name, in the order in which faces use them; primitive m shows material m, or there is one of
  // no material.
  std::map<std::string, uint32_t> known;
  std::vector<uint32_t> material_of(mesh.notes().changes.size() + 1, kNoIndex);
  std::vector<std::vector<uint32_t>> polygons;  // of every primitive
  for (uint32_t p = 0; p < mesh.polygon_ends.size(); ++p) {
    const uint32_t change = mesh.polygon_materials[p];
    if (material_of[change] == kNoIndex) {
      const std::string name = change == 0 ? std::string() : mesh.notes().changes[change - 1].name;
      const auto [entry, added] = known.try_emplace(name, static_cast<uint32_t>(polygons.size()));
      if (added) {
        polygons.emplace_back();
        scene.materials.push_back(obj.materials[name]);
        scene.materials.back().name = name;
      }
      material_of[change] = entry->second;
    }
    polygons[material_of[change]].push_back(p);
  }

  std::vector<uint32_t> vertex_of(mesh.corners.size());
  std::vector<bool> used;
  std::vector<glm::dvec3> points;
  std::vector<std::array<uint32_t, 3>> triangles;
  size_t effort = 0, uncut = 0;
  const auto beginOf = [&](uint32_t p) { return p == 0 ? 0u : mesh.polygon_ends[p - 1]; };
  for (uint32_t m = 0; m < polygons.size(); ++m) {
    used.assign(mesh.corners.size(), false);
    for (const uint32_t p : polygons[m])
      for (uint32_t i = beginOf(p); i < mesh.polygon_ends[p]; ++i) used[mesh.polygon_corners[i]] = true;
    std::vector<uint32_t> wanted;
    for (uint32_t place = 0; place < mesh.positions.size(); ++place)
      for (uint32_t c = mesh.firstCorner(place); c != kNoIndex; c = mesh.corners[c].next) {
        if (!used[c]) continue;
        vertex_of[c] = static_cast<uint32_t>(wanted.size());
        wanted.push_back(c);
      }

    Primitive primitive = makePrimitive(mesh, wanted);
    for (const glm::vec3& p : primitive.positions)
      if (!finite(p)) fail("a position is not finite");
    for (const uint32_t p : polygons[m]) {
      const uint32_t* corner = &mesh.polygon_corners[beginOf(p)];
      scene.polygons += mesh.polygon_ends[p] - beginOf(p) > 3;
      points.clear();
      for (uint32_t i = beginOf(p); i < mesh.polygon_ends[p]; ++i)
        points.emplace_back(mesh.positions[mesh.corners[mesh.polygon_corners[i]].place]);
      uncut += !triangulate(points, triangles, effort);
      for (const auto& triangle : triangles)
        for (const uint32_t i : triangle) primitive.indices.push_back(vertex_of[corner[i]]);
    }
    scene.primitives.push_back(std::move(primitive));
  }

  const std::string name = file.stem().string();
  scene.rig.nodes.push_back(Node{.name = name});
  scene.rig.palette.push_back({0, glm::dmat4(1.0)});
  const bool nameless =
      scene.materials.size() == 1 && scene.materials[0].name.empty() && scene.images.empty();
  for (uint32_t m = 0; m < polygons.size(); ++m) {
    Part part;
    part.mesh = name;
    part.primitive = m;
    part.material = nameless ? kNoIndex : m;
    scene.parts.push_back(std::move(part));
  }
  if (nameless) scene.materials.clear();
  for (size_t m = 0; m < scene.materials.size(); ++m)
    if (scene.materials[m].name.empty()) scene.materials[m].name = "material " + std::to_string(m);

  size_t unused = 0;
  for (uint32_t place = 0; place < mesh.positions.size(); ++place)
    unused += mesh.firstCorner(place) == kNoIndex;
  if (unused > 0)
    scene.warnings.push_back(std::to_string(unused) + " vertices belong to no face and are left out");
  if (uncut > 0)
    scene.warnings.push_back(std::to_string(uncut) +
                             " polygons are not convex and have more corners than furrow cuts well: "
                             "triangulate them");
  if (mesh.faces_without_area > 0)
    scene.warnings.push_back(std::to_string(mesh.faces_without_area) +
                             " faces have fewer than three corners");
  return scene;
}

}  // namespace furrow::pipeline
