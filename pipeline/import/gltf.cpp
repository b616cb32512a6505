#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/import/gltf_document.h"
#include "pipeline/one_line.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

constexpr double kWeightSumNoise = 1e-6;  // left as it is
constexpr double kWeightSumSlack = 1e-3;  // corrected without a word

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

template <typename T>
std::span<float> flat(std::vector<T>& vectors) {
  return {reinterpret_cast<float*>(vectors.data()), vectors.size() * sizeof(T) / sizeof(float)};
}

bool allFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

class GltfImporter {
 public:
  GltfImporter(const std::filesystem::path& file, std::vector<uint8_t> bytes)
      : document_(file, std::move(bytes)), model_(document_.model()) {}

  SourceScene run() {
    scene_.warnings = document_.warnings();
    if (document_.uses("EXT_mesh_gpu_instancing"))
      warn("it uses EXT_mesh_gpu_instancing, which furrow does not read: each of its meshes is taken once");
    readNodes();
    findShown();
    readMaterials();
    for (size_t m = 0; m < model_.meshes.size(); ++m) readMesh(m);
    if (scene_.parts.empty()) fail("it has no triangles");
    for (const tinygltf::Animation& animation : model_.animations) readClip(animation);
    reportRepairs();
    scene_.dependencies = document_.dependencies();
    return std::move(scene_);
  }

 private:
  struct Range {
    uint32_t begin = 0;
    uint32_t count = 0;
  };

  void warn(std::string text) { scene_.warnings.push_back(std::move(text)); }

  void readNodes() {
    std::vector<Node>& nodes = scene_.rig.nodes;
    nodes.resize(model_.nodes.size());
    for (size_t n = 0; n < nodes.size(); ++n) {
      const tinygltf::Node& in = model_.nodes[n];
      Node& node = nodes[n];
      node.name = in.name;
      const auto expect = [&](const std::vector<double>& numbers, size_t count, const char* what) {
        if (!numbers.empty() && numbers.size() != count)
          fail(named("node", n, in.name) + " has a " + what + " of " + std::to_string(numbers.size()) +
               " numbers");
        for (const double number : numbers)
          if (!(std::abs(number) <= double{std::numeric_limits<float>::max()}))
            fail(named("node", n, in.name) + " has a " + what + " that is no float");
      };
      expect(in.matrix, 16, "matrix");
      expect(in.translation, 3, "translation");
      expect(in.rotation, 4, "rotation");
      expect(in.scale, 3, "scale");
      node.has_matrix = !in.matrix.empty();
      if (node.has_matrix) node.matrix = glm::make_mat4(in.matrix.data());
      if (!in.translation.empty()) node.translation = glm::make_vec3(in.translation.data());
      if (!in.scale.empty()) node.scale = glm::make_vec3(in.scale.data());
      if (!in.rotation.empty()) {
        const glm::dquat q(in.rotation[3], in.rotation[0], in.rotation[1], in.rotation[2]);
        const double length = glm::length(q);
        if (length > 0.0 && std::isfinite(length))
          node.rotation = q / length;
        else
          warn(named("node", n, in.name) + " has a rotation of length zero, taken as none");
      }
    }
    for (size_t n = 0; n < nodes.size(); ++n) {
      for (const int child : model_.nodes[n].children) {
        if (child < 0 || static_cast<size_t>(child) >= nodes.size())
          fail("node " + std::to_string(n) + " has a child that does not exist");
        uint32_t& parent = nodes[static_cast<size_t>(child)].parent;
        if (parent != kNoIndex) fail("node " + std::to_string(child) + " has two parents");
        parent = static_cast<uint32_t>(n);
      }
    }
    // Every node has one parent at most, so that a cycle is what no root leads to.
    const std::vector<bool> reached = reachedFrom(roots());
    for (size_t n = 0; n < nodes.size(); ++n)
      if (!reached[n]) fail("node " + std::to_string(n) + " is its own ancestor");
  }

  std::vector<uint32_t> roots() const {
    std::vector<uint32_t> roots;
    for (uint32_t n = 0; n < model_.nodes.size(); ++n)
      if (scene_.rig.nodes[n].parent == kNoIndex) roots.push_back(n);
    return roots;
  }

  std::vector<bool> reachedFrom(std::vector<uint32_t> pending) const {
    std::vector<bool> reached(model_.nodes.size(), false);
    while (!pending.empty()) {
      const uint32_t n = pending.back();
      pending.pop_back();
      if (reached[n]) continue;
      reached[n] = true;
      for (const int child : model_.nodes[n].children) pending.push_back(static_cast<uint32_t>(child));
    }
    return reached;
  }

  // Which nodes show which mesh: those of the default scene or the first, else all, else one of our own a
  // mesh.
  void findShown() {
    shown_.resize(model_.meshes.size());
    const auto show = [&](const std::vector<bool>& reached) {
      bool any = false;
      for (uint32_t n = 0; n < reached.size(); ++n) {
        const int mesh = model_.nodes[n].mesh;
        if (!reached[n] || mesh < 0) continue;
        if (static_cast<size_t>(mesh) >= shown_.size())
          fail(named("node", n, model_.nodes[n].name) + " shows a mesh that does not exist");
        shown_[static_cast<size_t>(mesh)].push_back(n);
        any = true;
      }
      return any;
    };
    const size_t scene = static_cast<size_t>(std::max(model_.defaultScene, 0));
    if (scene < model_.scenes.size()) {
      std::vector<uint32_t> nodes;
      for (const int n : model_.scenes[scene].nodes) {
        if (n < 0 || static_cast<size_t>(n) >= model_.nodes.size())
          fail("a scene holds a node that does not exist");
        nodes.push_back(static_cast<uint32_t>(n));
      }
      if (show(reachedFrom(std::move(nodes)))) return;
    }
    if (show(std::vector<bool>(model_.nodes.size(), true))) {
      if (model_.defaultScene >= 0)
        warn("its default scene shows no mesh or does not exist: all nodes are taken");
      return;
    }
    if (!model_.meshes.empty()) warn("no node shows a mesh: every mesh is taken as it stands");
    for (size_t m = 0; m < model_.meshes.size(); ++m) {
      shown_[m].push_back(static_cast<uint32_t>(scene_.rig.nodes.size()));
      scene_.rig.nodes.push_back(Node{.name = model_.meshes[m].name});
    }
  }

  void readMaterials() {
    for (const tinygltf::Material& in : model_.materials) {
      Material material;
      material.name = in.name.empty() ? named("material", scene_.materials.size()) : in.name;
      const auto glossy = in.extensions.find(kSpecularGlossiness);
      std::vector<double> color = in.pbrMetallicRoughness.baseColorFactor;
      if (glossy != in.extensions.end()) color = numbersOf(glossy->second.Get("diffuseFactor"));
      for (size_t c = 0; c < std::min<size_t>(color.size(), 4); ++c)
        material.base_color[static_cast<int>(c)] = static_cast<float>(std::clamp(color[c], 0.0, 1.0));
      const double roughness = in.pbrMetallicRoughness.roughnessFactor;  // 1 where the file says nothing
      if (roughness >= 0.0 && roughness < 1.0) material.roughness = static_cast<float>(roughness);
      MaterialMaps& maps = material.maps;
      const float opacity = std::exchange(material.base_color.a, 1.0f);
      if (in.alphaMode == "BLEND") {
        material.base_color.a = opacity;
        maps.opaque_from = kBlendCutoff * opacity;
      } else if (in.alphaMode == "MASK") {
        const float cutoff = std::clamp(static_cast<float>(in.alphaCutoff), 0.0f, 1.0f);
        if (opacity < cutoff)
          material.base_color.a = 0.0f;
        else if (cutoff > 0.0f)
          maps.opaque_from = cutoff / opacity;
      }
      if (glossy != in.extensions.end())
        maps.color = readMap(textureInfo(glossy->second.Get("diffuseTexture")), in, "base colour");
      else
        maps.color = readMap(in.pbrMetallicRoughness.baseColorTexture, in, "base colour");
      maps.normal = readMap(in.normalTexture, in, "normal");
      if (std::abs(in.normalTexture.scale) <= double{std::numeric_limits<float>::max()})
        maps.normal_scale = static_cast<float>(in.normalTexture.scale);
      scene_.materials.push_back(std::move(material));
    }
  }

  template <typename Info>
  MaterialMap readMap(const Info& info, const tinygltf::Material& material, const char* use) {
    MaterialMap map;
    if (info.index < 0) return map;
    try {
      int set = info.texCoord;
      if (const auto found = info.extensions.find("KHR_texture_transform"); found != info.extensions.end())
        readTransform(found->second, map.uv, set);
      if (set != 0)
        fail("it lies in TEXCOORD_" + std::to_string(set) + ", and furrow keeps TEXCOORD_0 alone");
      const int number = document_.imageOfTexture(info.index);
      const auto [entry, added] = images_.try_emplace(number, static_cast<uint32_t>(scene_.images.size()));
      if (added) scene_.images.push_back(document_.image(number));
      map.image = entry->second;
      map.wrap = document_.wrapOfTexture(info.index);
    } catch (const std::runtime_error& e) {
      warn(named("material", static_cast<size_t>(&material - model_.materials.data()), material.name) +
           ": its " + use + " texture is left out: " + e.what());
    }
    return map;
  }

  static std::vector<double> numbersOf(const tinygltf::Value& list) {
    std::vector<double> numbers;
    for (size_t i = 0; list.IsArray() && i < list.ArrayLen(); ++i)
      numbers.push_back(
          list.Get(static_cast<int>(i)).IsNumber() ? list.Get(static_cast<int>(i)).GetNumberAsDouble() : 1.0);
    return numbers;
  }

  static tinygltf::TextureInfo textureInfo(const tinygltf::Value& value) {
    tinygltf::TextureInfo info;
    if (!value.IsObject()) return info;
    if (const tinygltf::Value& index = value.Get("index"); index.IsInt()) info.index = index.Get<int>();
    if (const tinygltf::Value& set = value.Get("texCoord"); set.IsInt()) info.texCoord = set.Get<int>();
    if (const tinygltf::Value& extensions = value.Get("extensions");
        extensions.IsObject() && extensions.Get("KHR_texture_transform").IsObject())
      info.extensions.emplace("KHR_texture_transform", extensions.Get("KHR_texture_transform"));
    return info;
  }

  // KHR_texture_transform: scaled, turned, moved.
  static void readTransform(const tinygltf::Value& transform, glm::mat3x2& uv, int& set) {
    const auto number = [](const tinygltf::Value& value, double otherwise) {
      return static_cast<float>(value.IsNumber() ? value.GetNumberAsDouble() : otherwise);
    };
    const auto pair = [&](const char* key, double otherwise) {
      const tinygltf::Value& value = transform.Get(key);
      if (!value.IsArray() || value.ArrayLen() != 2) return glm::vec2(static_cast<float>(otherwise));
      return glm::vec2(number(value.Get(0), otherwise), number(value.Get(1), otherwise));
    };
    const glm::vec2 scale = pair("scale", 1.0);
    const float turn = number(transform.Get("rotation"), 0.0);
    uv[0] = glm::vec2(std::cos(turn), -std::sin(turn)) * scale.x;
    uv[1] = glm::vec2(std::sin(turn), std::cos(turn)) * scale.y;
    uv[2] = pair("offset", 0.0);
    for (int column = 0; column < 3; ++column)
      if (!std::isfinite(uv[column].x) || !std::isfinite(uv[column].y)) fail("its transform is not finite");
    if (const tinygltf::Value& other = transform.Get("texCoord"); other.IsInt()) set = other.Get<int>();
  }

  void readMesh(size_t m) {
    const tinygltf::Mesh& mesh = model_.meshes[m];
    if (shown_[m].empty()) return;
    size_t targets = 0;
    for (const tinygltf::Primitive& primitive : mesh.primitives)
      targets = std::max(targets, primitive.targets.size());

    std::vector<std::pair<uint32_t, uint32_t>> primitives;  // ours, its material
    for (size_t p = 0; p < mesh.primitives.size(); ++p) {
      where_ = named("mesh", m, mesh.name) + ", primitive " + std::to_string(p);
      if (isLines(mesh.primitives[p])) {
        readLines(mesh.primitives[p], m);
        continue;
      }
      std::optional<Primitive> primitive = readPrimitive(mesh.primitives[p], targets);
      if (!primitive) continue;
      const int material = mesh.primitives[p].material;
      if (material >= 0 && static_cast<size_t>(material) >= scene_.materials.size())
        fail(where_ + " has a material that does not exist");
      primitives.emplace_back(static_cast<uint32_t>(scene_.primitives.size()),
                              material < 0 ? kNoIndex : static_cast<uint32_t>(material));
      scene_.primitives.push_back(std::move(*primitive));
    }
    if (primitives.empty()) return;
    where_ = named("mesh", m, mesh.name);

    std::vector<uint32_t> first_morphs;
    for (const uint32_t node : shown_[m])
      first_morphs.push_back(addMorphs(mesh, node, static_cast<uint32_t>(targets)));
    for (const auto& [primitive, material] : primitives) {
      for (size_t i = 0; i < shown_[m].size(); ++i) {
        Part part;
        part.node = shown_[m][i];
        part.mesh = mesh.name.empty() ? scene_.rig.nodes[part.node].name : mesh.name;
        if (part.mesh.empty()) part.mesh = named("mesh", m);
        part.primitive = primitive;
        part.material = material;
        part.first_morph = first_morphs[i];
        bind(part);
        scene_.parts.push_back(std::move(part));
      }
    }
  }

  uint32_t addMorphs(const tinygltf::Mesh& mesh, uint32_t node, uint32_t targets) {
    const uint32_t first = static_cast<uint32_t>(scene_.rig.morphs.size());
    const std::vector<double>* weights = &mesh.weights;
    if (node < model_.nodes.size() && !model_.nodes[node].weights.empty())
      weights = &model_.nodes[node].weights;
    // Some exporters (of VRM, above all) put the names into the primitives.
    const tinygltf::Value* names = nullptr;
    const auto find_names = [&names](const tinygltf::Value& extras) {
      if (!names && extras.IsObject() && extras.Get("targetNames").IsArray())
        names = &extras.Get("targetNames");
    };
    find_names(mesh.extras);
    for (const tinygltf::Primitive& primitive : mesh.primitives) find_names(primitive.extras);
    for (uint32_t t = 0; t < targets; ++t) {
      MorphTarget morph{.name = {}, .node = node, .index = t, .default_weight = 0.0};
      if (names && t < names->ArrayLen() && names->Get(static_cast<int>(t)).IsString())
        morph.name = oneLine(names->Get(static_cast<int>(t)).Get<std::string>());
      if (t < weights->size()) morph.default_weight = (*weights)[t];
      if (!(std::abs(morph.default_weight) <= double{std::numeric_limits<float>::max()}))
        fail(where_ + " gives a morph target a weight that is no float");
      scene_.rig.morphs.push_back(std::move(morph));
    }
    return first;
  }

  // The part's range of the palette.
  void bind(Part& part) {
    const Primitive& primitive = scene_.primitives[part.primitive];
    const int skin = part.node < model_.nodes.size() ? model_.nodes[part.node].skin : -1;
    if (skin >= 0 && primitive.influences > 0) {
      const Range range = skinPalette(skin);
      const auto highest = std::max_element(primitive.joints.begin(), primitive.joints.end());
      if (highest != primitive.joints.end() && *highest >= range.count)
        fail(where_ + " follows joint " + std::to_string(*highest) + " of a skin of " +
             std::to_string(range.count));
      part.skinned = true;
      part.palette_begin = range.begin;
      part.palette_count = range.count;
      return;
    }
    if (skin >= 0) warn(where_ + " has a skin but no joints and weights: it follows its node");
    const auto [entry, added] =
        node_palette_.try_emplace(part.node, static_cast<uint32_t>(scene_.rig.palette.size()));
    if (added) scene_.rig.palette.push_back({part.node, glm::dmat4(1.0)});
    part.palette_begin = entry->second;
    part.palette_count = 1;
  }

  Range skinPalette(int index) {
    if (static_cast<size_t>(index) >= model_.skins.size()) fail("a node has a skin that does not exist");
    const auto known = skin_palettes_.find(index);
    if (known != skin_palettes_.end()) return known->second;
    const tinygltf::Skin& skin = model_.skins[static_cast<size_t>(index)];
    const std::string name = named("skin", static_cast<size_t>(index), skin.name);
    if (skin.joints.empty() || skin.joints.size() > std::numeric_limits<uint16_t>::max() + size_t{1})
      fail(name + " has " + std::to_string(skin.joints.size()) + " joints");

    std::vector<PaletteEntry> entries;
    std::vector<float> matrices;
    if (skin.inverseBindMatrices >= 0) {
      const AccessorView view = document_.accessor(skin.inverseBindMatrices);
      if (!view.isFloat() || view.components != 16 || view.count < skin.joints.size())
        fail(name + " has no inverse bind matrix for every joint");
      matrices.resize(16 * view.count);
      readFloats(view, false, matrices);
      if (!allFinite(matrices)) fail(name + " has an inverse bind matrix that is not finite");
    }
    for (size_t j = 0; j < skin.joints.size(); ++j) {
      const int node = skin.joints[j];
      if (node < 0 || static_cast<size_t>(node) >= model_.nodes.size())
        fail(name + " has a joint that does not exist");
      const glm::dmat4 inverse_bind =
          matrices.empty() ? glm::dmat4(1.0) : glm::dmat4(glm::make_mat4(&matrices[16 * j]));
      entries.push_back({static_cast<uint32_t>(node), inverse_bind});
    }

    // Exporters write a skin for every mesh; equal ones share their entries.
    std::vector<PaletteEntry>& palette = scene_.rig.palette;
    const auto equal = [](const PaletteEntry& a, const PaletteEntry& b) {
      return a.node == b.node && a.inverse_bind == b.inverse_bind;
    };
    for (const auto& [other, range] : skin_palettes_) {
      const auto begin = palette.begin() + range.begin;
      if (std::equal(begin, begin + range.count, entries.begin(), entries.end(), equal))
        return skin_palettes_.emplace(index, range).first->second;
    }
    const Range range{static_cast<uint32_t>(palette.size()), static_cast<uint32_t>(entries.size())};
    palette.insert(palette.end(), entries.begin(), entries.end());
    return skin_palettes_.emplace(index, range).first->second;
  }

  // What a primitive's attribute of that name reads from.
  std::optional<AccessorView> attribute(const tinygltf::Primitive& in, const DracoMesh* draco,
                                        const std::string& name) {
    const auto entry = in.attributes.find(name);
    if (entry == in.attributes.end()) return std::nullopt;
    const auto packed = draco ? draco->attributes.find(name) : decltype(draco->attributes.find(name)){};
    if (!draco || packed == draco->attributes.end()) return document_.accessor(entry->second);
    const DracoAttribute& decoded = packed->second;
    AccessorView view;
    view.count = draco->vertices;
    view.component_type = decoded.component_type;
    view.components = decoded.components;
    view.stride = decoded.components ? decoded.bytes.size() / std::max<size_t>(draco->vertices, 1) : 0;
    view.bytes = decoded.bytes.data();
    if (entry->second >= 0 && static_cast<size_t>(entry->second) < model_.accessors.size())
      view.normalized = model_.accessors[static_cast<size_t>(entry->second)].normalized;
    return view;
  }

  void expect(const AccessorView& view, const std::string& name, uint32_t components, size_t count) const {
    if (view.components != components)
      fail(where_ + ": " + name + " has " + std::to_string(view.components) + " components and not " +
           std::to_string(components));
    if (view.count != count)
      fail(where_ + ": " + name + " has " + std::to_string(view.count) + " elements for " +
           std::to_string(count) + " vertices");
  }

  // Positions, normals and tangents are floats, or the small integers of KHR_mesh_quantization.
  void expectVector(const AccessorView& view, const std::string& name, uint32_t components,
                    size_t count) const {
    expect(view, name, components, count);
    if (!view.isFloat() && !document_.uses("KHR_mesh_quantization"))
      fail(where_ + ": " + name + " is not in floats and the file does not use KHR_mesh_quantization");
  }

  // Reads into `values` and counts the numbers that had to be set to 0 for being none.
  void readFinite(const AccessorView& view, bool normalized, std::span<float> values) {
    readFloats(view, normalized, values);
    for (float& value : values) {
      if (std::isfinite(value)) continue;
      value = 0.0f;
      ++repaired_numbers_;
    }
  }

  std::optional<Primitive> readPrimitive(const tinygltf::Primitive& in, size_t targets) {
    if (in.mode < TINYGLTF_MODE_POINTS || in.mode > TINYGLTF_MODE_TRIANGLE_FAN)
      fail(where_ + " has the unknown mode " + std::to_string(in.mode));
    if (in.mode == TINYGLTF_MODE_POINTS) {
      warn(where_ + " is left out: it is points");
      return std::nullopt;
    }
    const std::unique_ptr<const DracoMesh> draco = document_.draco(in);
    const std::optional<AccessorView> position = attribute(in, draco.get(), "POSITION");
    if (!position) {
      warn(where_ + " is left out: it has no positions");
      return std::nullopt;
    }
    const size_t vertices = position->count;
    expectVector(*position, "POSITION", 3, vertices);

    Primitive out;
    out.indices = readTriangles(in, draco.get(), vertices);
    if (out.indices.empty()) {
      warn(where_ + " is left out: it has no triangles");
      return std::nullopt;
    }
    out.positions.resize(vertices);
    readFloats(*position, position->normalized, flat(out.positions));
    if (!allFinite(flat(out.positions))) fail(where_ + " has a position that is not finite");

    if (const auto view = attribute(in, draco.get(), "NORMAL")) {
      expectVector(*view, "NORMAL", 3, vertices);
      out.normals.resize(vertices);
      readFinite(*view, view->normalized, flat(out.normals));
    }
    if (const auto view = attribute(in, draco.get(), "TANGENT")) {
      expectVector(*view, "TANGENT", 4, vertices);
      out.tangents.resize(vertices);
      readFinite(*view, view->normalized, flat(out.tangents));
    }
    if (const auto view = attribute(in, draco.get(), "TEXCOORD_0")) {
      expect(*view, "TEXCOORD_0", 2, vertices);
      out.uvs.resize(vertices);
      readFinite(*view, view->normalized || !document_.uses("KHR_mesh_quantization"), flat(out.uvs));
    }
    for (const auto& [name, accessor] : in.attributes)
      if (name.starts_with("COLOR_") || name.starts_with('_')) readAttribute(in, draco.get(), name, out);
    readSkinning(in, draco.get(), out);
    readMorphs(in, targets, out);
    return out;
  }

  static bool isLines(const tinygltf::Primitive& in) {
    return in.mode == TINYGLTF_MODE_LINE || in.mode == TINYGLTF_MODE_LINE_LOOP ||
           in.mode == TINYGLTF_MODE_LINE_STRIP;
  }

  void readLines(const tinygltf::Primitive& in, size_t m) {
    const std::optional<AccessorView> position = attribute(in, nullptr, "POSITION");
    if (!position) {
      warn(where_ + " is left out: it has no positions");
      return;
    }
    expectVector(*position, "POSITION", 3, position->count);
    std::vector<glm::vec3> positions(position->count);
    readFloats(*position, position->normalized, flat(positions));
    if (!allFinite(flat(positions))) fail(where_ + " has a position that is not finite");
    std::vector<uint32_t> list = readIndices(in, positions.size());
    if (in.mode == TINYGLTF_MODE_LINE_LOOP && !list.empty()) list.push_back(list.front());
    std::vector<glm::vec3> points;
    const size_t step = in.mode == TINYGLTF_MODE_LINE ? 2 : 1;
    for (size_t i = 0; i + 1 < list.size(); i += step)
      points.insert(points.end(), {positions[list[i]], positions[list[i + 1]]});
    for (const uint32_t node : shown_[m]) scene_.lines.push_back({model_.meshes[m].name, node, points});
  }

  void readAttribute(const tinygltf::Primitive& in, const DracoMesh* draco, const std::string& name,
                     Primitive& out) {
    const AccessorView view = *attribute(in, draco, name);
    if (view.components > 4) {
      warn(where_ + ": the attribute " + name + " is left out: it is a matrix");
      return;
    }
    const bool color = name.starts_with("COLOR_");
    expect(view, name, color ? std::max(view.components, 3u) : view.components, out.positions.size());
    Attribute attribute{name, view.components, std::vector<float>(view.count * view.components)};
    readFinite(view, color || view.normalized, attribute.values);
    out.attributes.push_back(std::move(attribute));
  }

  std::vector<uint32_t> readIndices(const tinygltf::Primitive& in, size_t vertices) {
    std::vector<uint32_t> list;
    if (in.indices >= 0) {
      const AccessorView view = document_.accessor(in.indices);
      if (view.components != 1) fail(where_ + " has indices that are not scalars");
      list = readUnsigned(view);
    } else {
      list.resize(vertices);
      std::iota(list.begin(), list.end(), 0u);
    }
    for (const uint32_t index : list)
      if (index >= vertices)
        fail(where_ + " has the index " + std::to_string(index) + " of " + std::to_string(vertices) +
             " vertices");
    return list;
  }

  std::vector<uint32_t> readTriangles(const tinygltf::Primitive& in, const DracoMesh* draco,
                                      size_t vertices) {
    if (draco) return draco->indices;
    std::vector<uint32_t> list = readIndices(in, vertices);
    if (in.mode == TINYGLTF_MODE_TRIANGLES) {
      if (list.size() % 3 != 0)
        warn(where_ + " has indices that do not come in threes: the last ones are left out");
      list.resize(list.size() / 3 * 3);
      return list;
    }
    std::vector<uint32_t> triangles;
    for (size_t i = 0; i + 2 < list.size(); ++i) {
      const bool fan = in.mode == TINYGLTF_MODE_TRIANGLE_FAN;
      const uint32_t a = fan ? list[i + 1] : list[i];
      const uint32_t b = fan ? list[i + 2] : list[i + 1 + i % 2];
      const uint32_t c = fan ? list[0] : list[i + 2 - i % 2];
      // Strips are stitched together with triangles of no area.
      if (a != b && b != c && c != a) triangles.insert(triangles.end(), {a, b, c});
    }
    return triangles;
  }

  void readSkinning(const tinygltf::Primitive& in, const DracoMesh* draco, Primitive& out) {
    const size_t vertices = out.positions.size();
    std::vector<std::vector<uint32_t>> joints;
    std::vector<std::vector<float>> weights;
    for (size_t set = 0;; ++set) {
      const std::string joints_name = "JOINTS_" + std::to_string(set);
      const std::string weights_name = "WEIGHTS_" + std::to_string(set);
      const auto joints_view = attribute(in, draco, joints_name);
      const auto weights_view = attribute(in, draco, weights_name);
      if (!joints_view && !weights_view) break;
      if (!joints_view || !weights_view)
        fail(where_ + " has one of " + joints_name + " and " + weights_name + " only");
      expect(*joints_view, joints_name, 4, vertices);
      expect(*weights_view, weights_name, 4, vertices);
      joints.push_back(readUnsigned(*joints_view));
      weights.emplace_back(4 * vertices);
      readFloats(*weights_view, true, weights.back());
      if (!allFinite(weights.back())) fail(where_ + " has a skin weight that is not finite");
    }
    if (joints.empty()) return;

    const size_t sets = joints.size();
    out.influences = static_cast<uint32_t>(4 * sets);
    out.joints.resize(out.influences * vertices);
    out.weights.resize(out.influences * vertices);
    for (size_t v = 0; v < vertices; ++v) {
      uint16_t* joint = &out.joints[v * out.influences];
      float* weight = &out.weights[v * out.influences];
      double sum = 0.0;
      for (size_t i = 0; i < out.influences; ++i) {
        const uint32_t from = joints[i / 4][4 * v + i % 4];
        weight[i] = std::max(weights[i / 4][4 * v + i % 4], 0.0f);
        sum += static_cast<double>(weight[i]);
        if (from > std::numeric_limits<uint16_t>::max() && weight[i] > 0.0f)
          fail(where_ + " follows joint " + std::to_string(from));
        joint[i] = weight[i] > 0.0f ? static_cast<uint16_t>(from) : uint16_t{0};
      }
      if (sum == 0.0) {
        joint[0] =
            static_cast<uint16_t>(std::min<uint32_t>(joints[0][4 * v], std::numeric_limits<uint16_t>::max()));
        weight[0] = 1.0f;
        ++unbound_vertices_;
      } else if (std::abs(sum - 1.0) > kWeightSumNoise) {
        for (size_t i = 0; i < out.influences; ++i)
          weight[i] = static_cast<float>(static_cast<double>(weight[i]) / sum);
        if (std::abs(sum - 1.0) > kWeightSumSlack) ++unbalanced_vertices_;
      }
    }
  }

  void readMorphs(const tinygltf::Primitive& in, size_t targets, Primitive& out) {
    const size_t vertices = out.positions.size();
    out.morphs.resize(targets);
    std::vector<glm::vec3> positions, normals;
    for (size_t t = 0; t < in.targets.size(); ++t) {
      const auto read = [&](const char* name, std::vector<glm::vec3>& values) {
        const auto entry = in.targets[t].find(name);
        if (entry == in.targets[t].end()) return false;
        const std::string label = "target " + std::to_string(t) + " " + name;
        const AccessorView view = document_.accessor(entry->second);
        expectVector(view, label, 3, vertices);
        values.resize(vertices);
        readFloats(view, view.normalized, flat(values));
        if (!allFinite(flat(values))) fail(where_ + ": " + label + " is not finite");
        return true;
      };
      const bool has_positions = read("POSITION", positions);
      const bool has_normals = read("NORMAL", normals);
      MorphDelta& morph = out.morphs[t];
      for (uint32_t v = 0; v < vertices; ++v) {
        const glm::vec3 position = has_positions ? positions[v] : glm::vec3(0.0f);
        const glm::vec3 normal = has_normals ? normals[v] : glm::vec3(0.0f);
        if (position == glm::vec3(0.0f) && normal == glm::vec3(0.0f)) continue;
        morph.vertices.push_back(v);
        morph.positions.push_back(position);
        if (has_normals) morph.normals.push_back(normal);
      }
    }
  }

  void readClip(const tinygltf::Animation& animation) {
    Clip clip;
    clip.name = animation.name;
    const std::string name =
        named("animation", static_cast<size_t>(&animation - model_.animations.data()), clip.name);
    std::set<std::string> faults;
    for (const tinygltf::AnimationChannel& in : animation.channels) {
      try {
        clip.channels.push_back(readChannel(in, animation));
        clip.duration = std::max(clip.duration, static_cast<double>(clip.channels.back().times.back()));
      } catch (const std::runtime_error& e) {
        faults.insert(e.what());
      }
    }
    for (const std::string& fault : faults) warn(name + ": a channel is left out: " + fault);
    if (clip.channels.empty())
      warn(name + " is left out: it moves nothing that furrow knows");
    else
      scene_.rig.clips.push_back(std::move(clip));
  }

  Channel readChannel(const tinygltf::AnimationChannel& in, const tinygltf::Animation& animation) {
    if (in.target_node < 0 || static_cast<size_t>(in.target_node) >= model_.nodes.size())
      fail("it moves no node of the file");
    Channel channel;
    channel.node = static_cast<uint32_t>(in.target_node);
    uint32_t components = 3;
    if (in.target_path == "translation") {
      channel.path = ChannelPath::kTranslation;
    } else if (in.target_path == "rotation") {
      channel.path = ChannelPath::kRotation;
      components = 4;
    } else if (in.target_path == "scale") {
      channel.path = ChannelPath::kScale;
    } else if (in.target_path == "weights") {
      channel.path = ChannelPath::kWeights;
      components = static_cast<uint32_t>(
          std::count_if(scene_.rig.morphs.begin(), scene_.rig.morphs.end(),
                        [&](const MorphTarget& morph) { return morph.node == channel.node; }));
      if (components == 0) fail("its node shows no morph targets");
    } else {
      fail("it animates \"" + in.target_path + "\"");
    }
    if (channel.path != ChannelPath::kWeights && scene_.rig.nodes[channel.node].has_matrix)
      fail("its node has a matrix, which nothing may animate");

    if (in.sampler < 0 || static_cast<size_t>(in.sampler) >= animation.samplers.size())
      fail("it has no sampler");
    const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<size_t>(in.sampler)];
    if (sampler.interpolation == "STEP") {
      channel.interpolation = Interpolation::kStep;
    } else if (sampler.interpolation == "CUBICSPLINE") {
      channel.interpolation = Interpolation::kCubicSpline;
    } else if (sampler.interpolation != "LINEAR") {
      fail("its interpolation \"" + sampler.interpolation + "\" is unknown");
    }

    const AccessorView times = document_.accessor(sampler.input);
    if (!times.isFloat() || times.components != 1) fail("its times are not floats");
    channel.times.resize(times.count);
    readFloats(times, false, channel.times);
    if (!allFinite(channel.times) || channel.times.front() < 0.0f) fail("a time is negative or not finite");

    const AccessorView values = document_.accessor(sampler.output);
    const uint32_t width = channel.path == ChannelPath::kWeights ? 1 : components;
    const size_t key =
        components * (channel.interpolation == Interpolation::kCubicSpline ? size_t{3} : size_t{1});
    if (values.components != width || values.count * width != times.count * key)
      fail("its values do not match its times");
    channel.values.resize(values.count * width);
    readFloats(values, true, channel.values);
    if (!allFinite(channel.values)) fail("a value is not finite");
    dropRepeatedKeys(channel, key);
    return channel;
  }

  // Of keys at the same time the last one stays.
  static void dropRepeatedKeys(Channel& channel, size_t key) {
    size_t kept = 0;
    for (size_t k = 0; k < channel.times.size(); ++k) {
      if (k > 0 && channel.times[k] < channel.times[k - 1]) fail("its times run backwards");
      if (k > 0 && channel.times[k] == channel.times[k - 1]) --kept;
      channel.times[kept] = channel.times[k];
      std::copy_n(channel.values.begin() + static_cast<ptrdiff_t>(k * key), key,
                  channel.values.begin() + static_cast<ptrdiff_t>(kept * key));
      ++kept;
    }
    channel.times.resize(kept);
    channel.values.resize(kept * key);
  }

  void reportRepairs() {
    const auto report = [&](size_t count, const char* text) {
      if (count > 0) warn(std::to_string(count) + text);
    };
    report(repaired_numbers_,
           " numbers of normals, tangents, UVs or attributes are not finite and were set to 0");
    report(unbound_vertices_, " vertices have no skin weight and were bound to their first joint");
    report(unbalanced_vertices_, " vertices have skin weights that do not add up to 1 and were scaled");
  }

  static std::string named(const char* kind, size_t index, const std::string& name = {}) {
    return std::string(kind) + " " + std::to_string(index) + (name.empty() ? "" : " \"" + name + "\"");
  }

  GltfDocument document_;
  const tinygltf::Model& model_;
  SourceScene scene_;
  std::vector<std::vector<uint32_t>> shown_;  // nodes of every mesh, ascending
  std::map<int, Range> skin_palettes_;
  std::map<uint32_t, uint32_t> node_palette_;
  std::map<int, uint32_t> images_;  // number in the file, in the scene
  std::string where_;               // what is being read, for messages
  size_t repaired_numbers_ = 0;
  size_t unbound_vertices_ = 0;
  size_t unbalanced_vertices_ = 0;
};

}  // namespace

EmbeddedImage gltfImage(const std::filesystem::path& file, std::vector<uint8_t> bytes,
                        const std::string& name) {
  GltfDocument document(file, std::move(bytes));
  std::vector<std::string> names = document.imageNames();
  auto number = static_cast<size_t>(std::ranges::find(names, name) - names.begin());
  if (name.empty() || number == names.size()) {
    const char* end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data(), end, number);
    if (error != std::errc() || stop != end || number >= names.size()) {
      for (size_t i = 0; i < names.size(); ++i)
        if (names[i].empty()) names[i] = std::to_string(i);
      throw Error(Exit::kBadData, file.string(), "it has no image \"" + name + "\"",
                  names.empty() ? "give an image file" : "it has: " + joinNames(names));
    }
  }
  EmbeddedImage out{document.image(static_cast<int>(number)), document.dependencies()};
  if (!out.image.file.empty()) out.files.push_back(out.image.file);
  return out;
}

SourceScene importGltf(const std::filesystem::path& file, std::vector<uint8_t> bytes) {
  return GltfImporter(file, std::move(bytes)).run();
}

}  // namespace furrow::pipeline
