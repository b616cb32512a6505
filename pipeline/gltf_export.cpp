#include "pipeline/gltf_export.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>
#include <tuple>

#include "furrow/jobs.h"
#include "pipeline/import/gltf_document.h"
#include "pipeline/maps/encode.h"
#include "pipeline/maps/png.h"

namespace furrow::pipeline {
namespace {

using Object = tinygltf::Value::Object;
using Array = tinygltf::Value::Array;
using tinygltf::Value;

int number(size_t n) {
  return static_cast<int>(n);
}

// JSON holds UTF-8 alone, and names of other formats may be none.
std::string utf8(std::string_view text) {
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

Value text(std::string_view t) {
  return Value(utf8(t));
}

class Exporter {
 public:
  Exporter(const AssetView& asset, const Rig& rig) : asset_(asset), rig_(rig) {}

  std::vector<std::byte> run() {
    model_.asset.version = "2.0";
    model_.asset.generator = "furrow " FURROW_VERSION;
    model_.buffers.emplace_back();
    model_.scenes.emplace_back();
    model_.defaultScene = 0;
    addNodes();
    nameLayers();
    weighAtRest();
    for (const TextureSet& set : asset_.texture_sets) addImages(set);
    for (const BaseMaps& maps : asset_.base_maps) addOwnImages(maps);
    for (const Part& part : asset_.parts) addPart(part);
    for (const Clip& clip : rig_.clips) addClip(clip);
    const auto clean = [](auto& items) {
      for (auto& item : items) item.name = utf8(item.name);
    };
    clean(model_.nodes);
    clean(model_.meshes);
    clean(model_.materials);
    clean(model_.images);
    clean(model_.textures);
    clean(model_.animations);
    std::ostringstream out;
    tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, out, false, true);
    const std::string bytes = std::move(out).str();
    const auto all = std::as_bytes(std::span(bytes));
    return {all.begin(), all.end()};
  }

 private:
  // ---- Buffer ----

  template <class T>
  int addView(std::span<const T> values, int target = 0) {
    std::vector<unsigned char>& buffer = model_.buffers[0].data;
    buffer.resize((buffer.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = values.size_bytes();
    view.target = target;
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    buffer.insert(buffer.end(), bytes, bytes + values.size_bytes());
    model_.bufferViews.push_back(std::move(view));
    return number(model_.bufferViews.size() - 1);
  }

  int addAccessor(int view, int component_type, int type, size_t count, bool normalized = false) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = count;
    accessor.normalized = normalized;
    model_.accessors.push_back(std::move(accessor));
    return number(model_.accessors.size() - 1);
  }

  static int typeOf(size_t components) {
    constexpr int kTypes[] = {0, TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3,
                              TINYGLTF_TYPE_VEC4};
    return components == 16 ? TINYGLTF_TYPE_MAT4 : kTypes[components];
  }

  int addFloats(std::span<const float> values, size_t components, int target = 0) {
    return addAccessor(addView(values, target), TINYGLTF_COMPONENT_TYPE_FLOAT, typeOf(components),
                       values.size() / components);
  }
  int addVertexFloats(std::span<const float> values, size_t components) {
    return addFloats(values, components, TINYGLTF_TARGET_ARRAY_BUFFER);
  }

  // A part's vertices of an array that has an entry for every vertex of the asset.
  template <class T>
  static std::span<const float> floatsOf(const Part& part, std::span<const T> values) {
    const auto slice = values.subspan(part.vertex_begin, part.vertex_end - part.vertex_begin);
    return {reinterpret_cast<const float*>(slice.data()), slice.size_bytes() / sizeof(float)};
  }

  void setBounds(int accessor, std::span<const float> values, size_t components, bool with_zero = false) {
    std::vector<double> low(components, with_zero ? 0.0 : INFINITY),
        high(components, with_zero ? 0.0 : -INFINITY);
    for (size_t i = 0; i < values.size(); ++i) {
      low[i % components] = std::min(low[i % components], double{values[i]});
      high[i % components] = std::max(high[i % components], double{values[i]});
    }
    model_.accessors[static_cast<size_t>(accessor)].minValues = std::move(low);
    model_.accessors[static_cast<size_t>(accessor)].maxValues = std::move(high);
  }

  // ---- Nodes and clips ----

  void addNodes() {
    for (const Node& node : rig_.nodes) {
      tinygltf::Node& out = model_.nodes.emplace_back();
      out.name = node.name;
      if (node.has_matrix) {
        for (int c = 0; c < 4; ++c)
          for (int r = 0; r < 4; ++r) out.matrix.push_back(node.matrix[c][r]);
        continue;
      }
      // Always: tinygltf writes a node that says nothing as null.
      out.translation = {node.translation.x, node.translation.y, node.translation.z};
      out.rotation = {node.rotation.x, node.rotation.y, node.rotation.z, node.rotation.w};
      out.scale = {node.scale.x, node.scale.y, node.scale.z};
    }
    for (size_t n = 0; n < rig_.nodes.size(); ++n) place(number(n), rig_.nodes[n].parent);
  }

  void place(int node, uint32_t parent) {
    (parent == kNoIndex ? model_.scenes[0].nodes : model_.nodes[parent].children).push_back(node);
  }

  void addClip(const Clip& clip) {
    tinygltf::Animation animation;
    animation.name = clip.name;
    for (const Channel& channel : clip.channels) {
      const int input = addFloats(channel.times, 1);
      setBounds(input, channel.times, 1);
      if (channel.path != ChannelPath::kWeights) {
        constexpr const char* kPaths[] = {"translation", "rotation", "scale"};
        addChannel(animation, input, channel, number(channel.node), kPaths[static_cast<size_t>(channel.path)],
                   addFloats(channel.values, channel.path == ChannelPath::kRotation ? 4 : 3));
        continue;
      }
      // Every mesh has those of the node's targets that move it.
      const auto targets =
          static_cast<size_t>(std::ranges::count(rig_.morphs, channel.node, &MorphTarget::node));
      for (const auto& [node, morphs] : morphed_nodes_) {
        if (rig_.morphs[morphs[0]].node != channel.node) continue;
        std::vector<float> values;
        for (size_t key = 0; key < channel.values.size(); key += targets)
          for (uint32_t m : morphs) values.push_back(channel.values[key + rig_.morphs[m].index]);
        addChannel(animation, input, channel, node, "weights", addFloats(values, 1));
      }
    }
    if (!animation.channels.empty()) model_.animations.push_back(std::move(animation));
  }

  static void addChannel(tinygltf::Animation& animation, int input, const Channel& channel, int node,
                         const char* path, int output) {
    constexpr const char* kInterpolations[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    tinygltf::AnimationSampler sampler;
    sampler.input = input;
    sampler.output = output;
    sampler.interpolation = kInterpolations[static_cast<size_t>(channel.interpolation)];
    tinygltf::AnimationChannel target;
    target.sampler = number(animation.samplers.size());
    target.target_node = node;
    target.target_path = path;
    animation.samplers.push_back(std::move(sampler));
    animation.channels.push_back(std::move(target));
  }

  // ---- Layers ----

  void nameLayers() {
    std::set<std::string> taken;
    Array layers;
    for (const Layer& layer : asset_.layers) {
      std::string name(layer.name);
      for (char& c : name)
        c = std::isalnum(static_cast<unsigned char>(c))
                ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                : '_';
      while (!taken.insert(name).second) name += '_';
      suffixes_.push_back('_' + name);
      layers.push_back(
          Value(Object{{"name", text(layer.name)}, {"attributes", text("_*" + suffixes_.back())}}));
    }
    model_.extras = Value(Object{{"furrow", Value(Object{{"source", text(asset_.source)},
                                                         {"toolVersion", text(asset_.tool_version)},
                                                         {"layers", Value(layers)}})}});
  }

  void weighAtRest() {
    const std::vector<float> q(asset_.pointCount(), 1.0f);
    rest_weights_.resize(size_t{asset_.vertexCount()} * asset_.weightStride());
    for (uint32_t l = 0; l < asset_.layerCount(); ++l)
      RespondJob{&asset_, l, asset_.layers[l].response, 0.0f, q, rest_weights_}.run(0, asset_.vertexCount());
  }

  void addLayerAttributes(const Part& part, std::map<std::string, int>& attributes) {
    const uint32_t count = part.vertex_end - part.vertex_begin;
    std::vector<float> values(count);
    const auto add = [&](const std::string& name, const auto& value) {
      for (uint32_t v = 0; v < count; ++v) values[v] = value(part.vertex_begin + v);
      attributes[name] = addVertexFloats(values, 1);
    };
    if (asset_.pointCount() <= uint32_t{1} << 24)
      add("_POINT", [&](uint32_t v) { return static_cast<float>(asset_.vertex_point[v]); });
    for (uint32_t l = 0; l < asset_.layerCount(); ++l) {
      const Layer& layer = asset_.layers[l];
      add("_WEIGHT" + suffixes_[l], [&](uint32_t v) {
        return static_cast<float>(rest_weights_[size_t{v} * asset_.weightStride() + l]) / 32767.0f;
      });
      add("_MASK" + suffixes_[l],
          [&](uint32_t v) { return layer.mask.empty() ? 1.0f : static_cast<float>(layer.mask[v]) / 255.0f; });
      if (!layer.bias.empty())
        add("_BIAS" + suffixes_[l], [&](uint32_t v) { return static_cast<float>(layer.bias[v]) / 32767.0f; });
      if (layer.directions.empty()) continue;
      const auto direction = [&](uint32_t v) {
        return &layer.directions[size_t{4} * asset_.vertex_point[v]];
      };
      add("_CONFIDENCE" + suffixes_[l],
          [&](uint32_t v) { return static_cast<float>(direction(v)[3]) / 127.0f; });
      std::vector<float> directions;
      for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v) {
        const int8_t* d = direction(v);
        const float length = std::sqrt(static_cast<float>(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        for (int c = 0; c < 3; ++c)
          directions.push_back(length > 0.0f ? static_cast<float>(d[c]) / length : 0.0f);
      }
      attributes["_DIRECTION" + suffixes_[l]] = addVertexFloats(directions, 3);
    }
  }

  // ---- Maps ----

  static constexpr Wrap kTiles[2] = {Wrap::kRepeat, Wrap::kRepeat};

  // The texture that shows an image.
  int addImage(const std::string& name, const ByteImage& pixels, const Wrap (&wrap)[2] = kTiles) {
    tinygltf::Image image;
    image.name = name;
    image.mimeType = "image/png";
    image.bufferView = addView(std::span<const std::byte>(encodePng(pixels)));
    model_.images.push_back(std::move(image));
    tinygltf::Texture texture;
    texture.name = name;
    texture.source = number(model_.images.size() - 1);
    if (!std::ranges::equal(wrap, kTiles)) {
      constexpr int kWays[] = {TINYGLTF_TEXTURE_WRAP_REPEAT, TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE,
                               TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT};
      tinygltf::Sampler sampler;
      sampler.wrapS = kWays[static_cast<size_t>(wrap[0])];
      sampler.wrapT = kWays[static_cast<size_t>(wrap[1])];
      texture.sampler = number(model_.samplers.size());
      model_.samplers.push_back(std::move(sampler));
    }
    model_.textures.push_back(std::move(texture));
    return number(model_.textures.size() - 1);
  }

  static ByteImage normalPixels(const Image& slopes) {
    Image image{slopes.width, slopes.height, 3, {}};
    for (size_t i = 0; i < slopes.pixels.size(); i += 2) {
      const float x = slopes.pixels[i] * 2.0f - 1.0f, y = slopes.pixels[i + 1] * 2.0f - 1.0f;
      const float z = std::sqrt(std::max(1.0f - x * x - y * y, 1.0f / 257.0f));
      image.pixels.insert(image.pixels.end(), {slopes.pixels[i], slopes.pixels[i + 1], z * 0.5f + 0.5f});
    }
    return toBytes(image);
  }

  // What a material's extras say of the maps of its texture set.
  void addImages(const TextureSet& set) {
    const std::string prefix = set.name.empty() ? "furrow" : std::string(set.name);
    std::vector<int> masks;
    for (uint32_t s = 0; s < set.masks.slices; ++s)
      masks.push_back(addImage(prefix + " masks " + std::to_string(s), toBytes(decode(set.masks, s))));
    Array layers;
    for (uint32_t l = 0; l < asset_.layerCount(); ++l) {
      const Layer& layer = asset_.layers[l];
      Object maps{{"name", text(layer.name)}};
      if (!masks.empty() && layer.mask_slice != kAbsent)
        maps["mask"] = Value(Object{{"texture", Value(masks[layer.mask_slice / 4])},
                                    {"channel", text(std::string(1, "rgba"[layer.mask_slice % 4]))}});
      for (const auto& [pose, slice] :
           {std::pair{"compress", set.compress_slice[l]}, {"stretch", set.stretch_slice[l]}}) {
        if (slice == kAbsent || set.normals.slices == 0) continue;
        const std::string name = prefix + ' ' + std::string(layer.name) + ' ' + pose;
        const Float4& window = set.windows[slice];
        const auto pair = [](float x, float y) { return Value(Array{Value(double{x}), Value(double{y})}); };
        maps[pose] = Value(
            Object{{"normal", Value(addImage(name + " normal", normalPixels(decode(set.normals, slice))))},
                   {"shading", Value(addImage(name + " shading", toBytes(decode(set.shading, slice))))},
                   {"low", pair(window.x, window.y)},
                   {"scale", pair(window.z, window.w)}});
      }
      layers.push_back(Value(maps));
    }
    set_extras_.push_back(Value(Object{{"furrow", Value(Object{{"layers", Value(layers)}})}}));
  }

  // The model's own colours and normals.
  void addOwnImages(const BaseMaps& maps) {
    const std::string prefix = "base " + std::to_string(own_textures_.size());
    OwnTextures& own = own_textures_.emplace_back();
    if (maps.color.slices > 0) {
      const bool opacity = maps.color.format == TextureFormat::kBc3;
      Image image{maps.color.width, maps.color.height, opacity ? 4u : 3u, {}};
      for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 0; x < image.width; ++x) {
          const Float4 texel = texelAt(maps.color, 0, 0, x, y);
          image.pixels.insert(image.pixels.end(), {texel.x, texel.y, texel.z});
          if (opacity) image.pixels.push_back(texel.w);
        }
      own.color = addImage(prefix + " color", toBytes(image), maps.color_wrap);
    }
    if (maps.normal.slices > 0)
      own.normal = addImage(prefix + " normal", normalPixels(decode(maps.normal, 0)), maps.normal_wrap);
  }

  // KHR_texture_transform: scaled, turned, moved; columns of the matrix as in BaseMaps.
  tinygltf::ExtensionMap transform(const float (&m)[6]) {
    if (std::ranges::equal(m, std::initializer_list<float>{1, 0, 0, 1, 0, 0})) return {};
    model_.extensionsUsed = {"KHR_texture_transform"};
    const double turn = std::atan2(double{-m[1]}, double{m[0]});
    const auto pair = [](double x, double y) { return Value(Array{Value(x), Value(y)}); };
    return {{"KHR_texture_transform",
             Value(Object{{"offset", pair(double{m[4]}, double{m[5]})},
                          {"rotation", Value(turn)},
                          {"scale", pair(std::hypot(double{m[0]}, double{m[1]}),
                                         std::sin(turn) * double{m[2]} + std::cos(turn) * double{m[3]})}})}};
  }

  void showOwnImages(const Part& part, tinygltf::Material& material) {
    if (part.base_maps == kAbsent) return;
    const BaseMaps& maps = asset_.base_maps[part.base_maps];
    const OwnTextures& own = own_textures_[part.base_maps];
    if (own.color >= 0) {
      material.pbrMetallicRoughness.baseColorTexture.index = own.color;
      material.pbrMetallicRoughness.baseColorTexture.extensions = transform(maps.color_uv);
    }
    if (own.normal >= 0) {
      material.normalTexture.index = own.normal;
      material.normalTexture.extensions = transform(maps.normal_uv);
    }
    if (maps.opaque_from > 0.0f && material.alphaMode != "BLEND") {
      material.alphaMode = "MASK";
      material.alphaCutoff = double{maps.opaque_from};
    }
  }

  int materialOf(const Part& part) {
    const auto key = std::tuple(part.material, part.base_color.x, part.base_color.y, part.base_color.z,
                                part.base_color.w, part.roughness, part.texture_set, part.base_maps);
    const auto [known, is_new] = materials_.emplace(key, number(model_.materials.size()));
    if (is_new) {
      tinygltf::Material material;
      material.name = part.material;
      material.pbrMetallicRoughness.baseColorFactor = {part.base_color.x, part.base_color.y,
                                                       part.base_color.z, part.base_color.w};
      material.pbrMetallicRoughness.metallicFactor = 0.0;
      material.pbrMetallicRoughness.roughnessFactor = part.roughness;
      if (part.base_color.w < 1.0f) material.alphaMode = "BLEND";
      showOwnImages(part, material);
      if (part.texture_set != kAbsent) material.extras = set_extras_[part.texture_set];
      model_.materials.push_back(std::move(material));
    }
    return known->second;
  }

  // ---- Parts ----

  void addPart(const Part& part) {
    if (part.vertex_begin == part.vertex_end || part.triangle_begin == part.triangle_end) return;
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = materialOf(part);
    std::vector<uint32_t> indices;
    for (uint32_t i = 3 * part.triangle_begin; i < 3 * part.triangle_end; ++i)
      indices.push_back(asset_.indices[i] - part.vertex_begin);
    primitive.indices =
        addAccessor(addView(std::span<const uint32_t>(indices), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER),
                    TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, indices.size());
    std::map<std::string, int>& attributes = primitive.attributes;
    const auto add = [&](const char* name, const auto& values, size_t components) {
      return attributes[name] = addVertexFloats(floatsOf(part, values), components);
    };
    setBounds(add("POSITION", asset_.positions, 3), floatsOf(part, asset_.positions), 3);
    add("NORMAL", asset_.normals, 3);
    if (part.has_uvs) {
      add("TANGENT", asset_.tangents, 4);
      add("TEXCOORD_0", asset_.uvs, 2);
    }
    if (!asset_.colors.empty()) attributes["COLOR_0"] = addColors(part);
    addLayerAttributes(part, attributes);

    tinygltf::Node node;
    node.name = part.mesh;
    const uint32_t parent = bind(part, node, attributes);
    tinygltf::Mesh mesh;
    mesh.name = part.mesh;
    const std::vector<uint32_t> morphs = morphsOf(part);
    Array names;
    for (uint32_t m : morphs) {
      primitive.targets.push_back(target(part, asset_.morphs[m]));
      mesh.weights.push_back(double{asset_.morphs[m].default_weight});
      names.push_back(text(asset_.morphs[m].name));
    }
    if (!morphs.empty()) {
      mesh.extras = Value(Object{{"targetNames", Value(names)}});
      morphed_nodes_.emplace_back(number(model_.nodes.size()), morphs);
    }
    mesh.primitives.push_back(std::move(primitive));
    node.mesh = number(model_.meshes.size());
    model_.meshes.push_back(std::move(mesh));
    model_.nodes.push_back(std::move(node));
    place(number(model_.nodes.size() - 1), parent);
  }

  // Linear, as glTF has them; of 16 bits, which hold the squares of 8.
  int addColors(const Part& part) {
    std::vector<uint16_t> linear;
    for (size_t i = size_t{4} * part.vertex_begin; i < size_t{4} * part.vertex_end; ++i) {
      const uint32_t root = asset_.colors[i];
      linear.push_back(
          static_cast<uint16_t>(i % 4 == 3 ? root * 257 : (root * root * 65535 + 32512) / 65025));
    }
    return addAccessor(addView(std::span<const uint16_t>(linear), TINYGLTF_TARGET_ARRAY_BUFFER),
                       TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, linear.size() / 4, true);
  }

  // Binds a part to the nodes that move it: as a child of the only one, or by a skin. Returns its parent.
  uint32_t bind(const Part& part, tinygltf::Node& node, std::map<std::string, int>& attributes) {
    const uint32_t influences = asset_.influences;
    std::map<uint32_t, uint16_t> joints;  // palette entry -> joint of the skin
    for (size_t i = size_t{influences} * part.vertex_begin; i < size_t{influences} * part.vertex_end; ++i)
      if (asset_.weights[i] > 0) joints.emplace(asset_.joints[i], uint16_t{0});
    if (joints.size() == 1 && rig_.palette[joints.begin()->first].inverse_bind == glm::dmat4(1.0))
      return rig_.palette[joints.begin()->first].node;

    tinygltf::Skin skin;
    std::vector<float> inverse_bind;
    for (auto& [entry, joint] : joints) {
      joint = static_cast<uint16_t>(skin.joints.size());
      skin.joints.push_back(number(rig_.palette[entry].node));
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
          inverse_bind.push_back(static_cast<float>(rig_.palette[entry].inverse_bind[c][r]));
    }
    skin.inverseBindMatrices = addFloats(inverse_bind, 16);
    node.skin = number(model_.skins.size());
    model_.skins.push_back(std::move(skin));
    for (uint32_t set = 0; 4 * set < influences; ++set) {
      std::vector<uint16_t> numbers, weights;
      for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v)
        for (uint32_t k = 4 * set; k < 4 * set + 4; ++k) {
          const size_t i = size_t{influences} * v + k;
          const bool used = k < influences && asset_.weights[i] > 0;
          numbers.push_back(used ? joints[asset_.joints[i]] : uint16_t{0});
          weights.push_back(used ? asset_.weights[i] : uint16_t{0});
        }
      const auto add = [&](const char* name, const std::vector<uint16_t>& values, bool normalized) {
        attributes[name + std::to_string(set)] = addAccessor(
            addView(std::span<const uint16_t>(values), TINYGLTF_TARGET_ARRAY_BUFFER),
            TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, values.size() / 4, normalized);
      };
      add("JOINTS_", numbers, false);
      add("WEIGHTS_", weights, true);
    }
    return kNoIndex;
  }

  // The targets that move the part; those that move nothing go with their siblings, so that no name is lost.
  std::vector<uint32_t> morphsOf(const Part& part) const {
    std::set<uint32_t> nodes;
    const auto moves = [&](const Morph& morph) {
      const auto first = std::lower_bound(morph.vertices.begin(), morph.vertices.end(), part.vertex_begin);
      return first != morph.vertices.end() && *first < part.vertex_end;
    };
    for (uint32_t m = 0; m < asset_.morphs.size(); ++m)
      if (moves(asset_.morphs[m])) nodes.insert(rig_.morphs[m].node);
    std::vector<uint32_t> morphs;
    for (uint32_t m = 0; m < asset_.morphs.size(); ++m)
      if (moves(asset_.morphs[m]) ||
          (asset_.morphs[m].vertices.empty() && nodes.contains(rig_.morphs[m].node)))
        morphs.push_back(m);
    return morphs;
  }

  std::map<std::string, int> target(const Part& part, const Morph& morph) {
    const auto begin = std::lower_bound(morph.vertices.begin(), morph.vertices.end(), part.vertex_begin);
    const auto end = std::lower_bound(begin, morph.vertices.end(), part.vertex_end);
    std::vector<uint32_t> vertices;
    for (auto v = begin; v != end; ++v) vertices.push_back(*v - part.vertex_begin);
    const auto first = static_cast<size_t>(begin - morph.vertices.begin());
    const auto deltas = [&](const auto& steps, float step) {
      std::vector<float> values;
      for (size_t i = 3 * first; i < 3 * (first + vertices.size()); ++i)
        values.push_back(step * static_cast<float>(steps[i]));
      return sparse(part, vertices, values);
    };
    std::map<std::string, int> target = {{"POSITION", deltas(morph.position_deltas, morph.position_step)}};
    if (!morph.normal_deltas.empty()) target["NORMAL"] = deltas(morph.normal_deltas, morph.normal_step);
    return target;
  }

  // Three floats a vertex, 0 but for some.
  int sparse(const Part& part, const std::vector<uint32_t>& vertices, const std::vector<float>& values) {
    const uint32_t count = part.vertex_end - part.vertex_begin;
    const int accessor = addAccessor(-1, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, count);
    setBounds(accessor, values, 3, vertices.size() < count);
    if (vertices.empty()) return accessor;
    auto& replaced = model_.accessors[static_cast<size_t>(accessor)].sparse;
    replaced.isSparse = true;
    replaced.count = number(vertices.size());
    replaced.indices.bufferView = addView(std::span(vertices));
    replaced.indices.byteOffset = 0;
    replaced.indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    replaced.values.bufferView = addView(std::span(values));
    replaced.values.byteOffset = 0;
    return accessor;
  }

  const AssetView& asset_;
  const Rig& rig_;
  tinygltf::Model model_;
  std::vector<std::string> suffixes_;  // of the attributes of every layer
  std::vector<int16_t> rest_weights_;
  std::vector<Value> set_extras_;
  struct OwnTextures {
    int color = -1, normal = -1;
  };
  std::vector<OwnTextures> own_textures_;  // of every BaseMaps
  std::map<std::tuple<std::string_view, float, float, float, float, float, uint32_t, uint32_t>, int>
      materials_;
  std::vector<std::pair<int, std::vector<uint32_t>>> morphed_nodes_;  // node, its targets in the asset
};

}  // namespace

std::vector<std::byte> exportGlb(const AssetView& asset, const Rig& rig) {
  return Exporter(asset, rig).run();
}

}  // namespace furrow::pipeline
