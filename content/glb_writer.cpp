#include <tiny_gltf.h>

#include <cstring>
#include <glm/common.hpp>
#include <span>
#include <stdexcept>

#include "content/scene.h"

namespace furrow::content {
namespace {

static_assert(sizeof(glm::vec3) == 12 && sizeof(glm::vec4) == 16 && sizeof(glm::u8vec4) == 4);

class Writer {
 public:
  explicit Writer(const Scene& scene) : scene_(scene) {
    model_.asset.version = "2.0";
    model_.asset.generator = "furrow_content";
    model_.buffers.emplace_back();
    for (const Image& image : scene.images) addImage(image);
    for (const Material& material : scene.materials) addMaterial(material);
    for (const Mesh& mesh : scene.meshes) addMesh(mesh);
    addNodes();
    if (!scene.joints.empty()) addSkin();
    for (const Clip& clip : scene.clips) addClip(clip);
  }

  void save(const std::filesystem::path& file) {
    tinygltf::TinyGLTF writer;
    if (!writer.WriteGltfSceneToFile(&model_, file.string(), true, true, false, true))
      throw std::runtime_error(file.string() + ": cannot be written");
  }

 private:
  template <class T>
  int addView(std::span<const T> values, int target = 0) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    bytes.resize((bytes.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = values.size_bytes();
    view.target = target;
    bytes.resize(bytes.size() + values.size_bytes());
    std::memcpy(bytes.data() + view.byteOffset, values.data(), values.size_bytes());
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size() - 1);
  }

  int push(int view, int component_type, int type, size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size() - 1);
  }

  template <class T>
  int addFloats(const std::vector<T>& values, int type, int target = TINYGLTF_TARGET_ARRAY_BUFFER) {
    return push(addView(std::span<const T>(values), target), TINYGLTF_COMPONENT_TYPE_FLOAT, type,
                values.size());
  }

  void bound(int accessor, std::span<const glm::vec3> values) {
    glm::vec3 low = values[0], high = values[0];
    for (glm::vec3 v : values) {
      low = glm::min(low, v);
      high = glm::max(high, v);
    }
    model_.accessors[accessor].minValues = {low.x, low.y, low.z};
    model_.accessors[accessor].maxValues = {high.x, high.y, high.z};
  }

  int addPositions(const std::vector<glm::vec3>& values) {
    const int accessor = addFloats(values, TINYGLTF_TYPE_VEC3);
    bound(accessor, values);
    return accessor;
  }

  // Only the vertices in `moved` are stored; the rest is zero by the rules of the format.
  int addSparse(const std::vector<glm::vec3>& values, const std::vector<uint32_t>& moved, bool bounded) {
    const int accessor = push(-1, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, values.size());
    if (bounded) bound(accessor, values);
    if (moved.empty()) return accessor;
    std::vector<glm::vec3> kept;
    kept.reserve(moved.size());
    for (uint32_t vertex : moved) kept.push_back(values[vertex]);
    auto& sparse = model_.accessors[accessor].sparse;
    sparse.isSparse = true;
    sparse.count = static_cast<int>(moved.size());
    sparse.indices = {0, addView(std::span<const uint32_t>(moved)), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT};
    sparse.values = {addView(std::span<const glm::vec3>(kept)), 0};
    return accessor;
  }

  // A texture of the same number as the image.
  void addImage(const Image& source) {
    tinygltf::Image image;
    image.mimeType = "image/png";
    image.bufferView = addView(std::span<const uint8_t>(encodePng(source)));
    tinygltf::Texture texture;
    texture.source = static_cast<int>(model_.images.size());
    model_.images.push_back(image);
    model_.textures.push_back(texture);
  }

  void addMaterial(const Material& source) {
    tinygltf::Material material;
    material.name = source.name;
    material.doubleSided = source.double_sided;
    material.pbrMetallicRoughness.baseColorFactor = {source.base_color.r, source.base_color.g,
                                                     source.base_color.b, 1.0};
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = source.roughness;
    material.pbrMetallicRoughness.baseColorTexture.index = source.color_image;
    material.normalTexture.index = source.normal_image;
    model_.materials.push_back(material);
  }

  tinygltf::Primitive primitive(const Primitive& source) {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = static_cast<int>(source.material);
    auto& attributes = primitive.attributes;
    attributes["POSITION"] = addPositions(source.positions);
    attributes["NORMAL"] = addFloats(source.normals, TINYGLTF_TYPE_VEC3);
    if (!source.uvs.empty()) attributes["TEXCOORD_0"] = addFloats(source.uvs, TINYGLTF_TYPE_VEC2);
    if (!source.colors.empty()) attributes["COLOR_0"] = addFloats(source.colors, TINYGLTF_TYPE_VEC4);
    for (const auto& [name, values] : source.vec3_attributes)
      attributes[name] = addFloats(values, TINYGLTF_TYPE_VEC3);
    for (const auto& [name, values] : source.vec4_attributes)
      attributes[name] = addFloats(values, TINYGLTF_TYPE_VEC4);
    if (!source.joints.empty()) {
      attributes["JOINTS_0"] =
          push(addView(std::span<const glm::u8vec4>(source.joints), TINYGLTF_TARGET_ARRAY_BUFFER),
               TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4, source.joints.size());
      attributes["WEIGHTS_0"] = addFloats(source.weights, TINYGLTF_TYPE_VEC4);
    }
    for (const Morph& morph : source.morphs) {
      std::vector<uint32_t> moved;
      for (uint32_t v = 0; v < morph.positions.size(); ++v)
        if (morph.positions[v] != glm::vec3(0) || morph.normals[v] != glm::vec3(0)) moved.push_back(v);
      primitive.targets.push_back({{"POSITION", addSparse(morph.positions, moved, true)},
                                   {"NORMAL", addSparse(morph.normals, moved, false)}});
    }
    primitive.indices =
        push(addView(std::span<const uint32_t>(source.indices), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER),
             TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, source.indices.size());
    return primitive;
  }

  void addMesh(const Mesh& source) {
    tinygltf::Mesh mesh;
    mesh.name = source.name;
    mesh.weights.assign(source.morphs.size(), 0.0);
    if (!source.morphs.empty()) {
      tinygltf::Value::Array names;
      for (const std::string& name : source.morphs) names.emplace_back(name);
      mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(names)}});
    }
    for (const Primitive& p : source.primitives) mesh.primitives.push_back(primitive(p));
    for (const std::vector<glm::vec3>& line : source.lines) {
      tinygltf::Primitive& strip = mesh.primitives.emplace_back();
      strip.mode = TINYGLTF_MODE_LINE_STRIP;
      strip.attributes["POSITION"] = addPositions(line);
    }
    model_.meshes.push_back(mesh);
  }

  void addNodes() {
    tinygltf::Scene root;
    for (uint32_t i = 0; i < scene_.nodes.size(); ++i) {
      const Node& source = scene_.nodes[i];
      tinygltf::Node node;
      node.name = source.name;
      node.mesh = source.mesh;
      if (source.skinned) node.skin = 0;
      if (source.translation != glm::vec3(0))
        node.translation = {source.translation.x, source.translation.y, source.translation.z};
      model_.nodes.push_back(node);
      if (source.parent < 0)
        root.nodes.push_back(static_cast<int>(i));
      else
        model_.nodes[source.parent].children.push_back(static_cast<int>(i));
    }
    model_.scenes.push_back(root);
    model_.defaultScene = 0;
  }

  void addSkin() {
    std::vector<glm::mat4> inverse_binds;
    tinygltf::Skin skin;
    for (uint32_t joint : scene_.joints) {
      glm::mat4 inverse(1.0f);
      for (int node = static_cast<int>(joint); node >= 0; node = scene_.nodes[node].parent)
        inverse[3] -= glm::vec4(scene_.nodes[node].translation, 0.0f);
      inverse_binds.push_back(inverse);
      skin.joints.push_back(static_cast<int>(joint));
    }
    skin.inverseBindMatrices = addFloats(inverse_binds, TINYGLTF_TYPE_MAT4, 0);
    model_.skins.push_back(skin);
  }

  void addClip(const Clip& clip) {
    tinygltf::Animation animation;
    animation.name = clip.name;
    const int input = addFloats(clip.times, TINYGLTF_TYPE_SCALAR, 0);
    model_.accessors[input].minValues = {clip.times.front()};
    model_.accessors[input].maxValues = {clip.times.back()};
    const auto add = [&](uint32_t node, const char* path, int output) {
      tinygltf::AnimationSampler sampler;
      sampler.input = input;
      sampler.output = output;
      sampler.interpolation = "LINEAR";
      tinygltf::AnimationChannel channel;
      channel.sampler = static_cast<int>(animation.samplers.size());
      channel.target_node = static_cast<int>(node);
      channel.target_path = path;
      animation.samplers.push_back(sampler);
      animation.channels.push_back(channel);
    };
    for (const WeightKeys& keys : clip.weights) {
      std::vector<float> values;
      for (const std::vector<float>& key : keys.weights) values.insert(values.end(), key.begin(), key.end());
      add(keys.node, "weights", addFloats(values, TINYGLTF_TYPE_SCALAR, 0));
    }
    for (const RotationKeys& keys : clip.rotations) {
      std::vector<glm::vec4> values;
      for (glm::quat r : keys.rotations) values.emplace_back(r.x, r.y, r.z, r.w);
      add(keys.node, "rotation", addFloats(values, TINYGLTF_TYPE_VEC4, 0));
    }
    model_.animations.push_back(animation);
  }

  const Scene& scene_;
  tinygltf::Model model_;
};

}  // namespace

void writeGlb(const Scene& scene, const std::filesystem::path& file) {
  Writer(scene).save(file);
}

}  // namespace furrow::content
