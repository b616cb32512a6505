#include "pipeline/import/simple_ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace furrow::pipeline {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

constexpr std::string_view kTexture = "texture_";

struct Type {
  std::string_view name, other_name;
  std::string_view count_name;  // of a list, by which OpenMesh reads as many bytes
  size_t size = 0;
};
constexpr Type kTypes[] = {{"char", "int8", "uchar", 1},    {"uchar", "uint8", "uchar", 1},
                           {"short", "int16", "uint16", 2}, {"ushort", "uint16", "uint16", 2},
                           {"int", "int32", "int", 4},      {"uint", "uint32", "int", 4},
                           {"float", "float32", "", 4},     {"double", "float64", "", 8}};

const Type& typeOf(std::string_view name) {
  for (const Type& type : kTypes)
    if (name == type.name || name == type.other_name) return type;
  fail("its header has the unknown type \"" + std::string(name.substr(0, 40)) + "\"");
}

struct Property {
  std::string_view name;
  const Type* type = nullptr;
  const Type* count = nullptr;  // of a list
  bool kept = false;
  bool as_float = false;  // a whole number that becomes a float
};

struct Element {
  std::string_view name;
  size_t count = 0;
  std::vector<Property> properties;
};

bool isSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && isSpace(text.back())) text.remove_suffix(1);
  return text;
}

class Simplifier {
 public:
  explicit Simplifier(std::string_view bytes) : rest_(bytes) {}

  std::vector<std::string> textures() {
    readHeader();
    return std::move(textures_);
  }

  SimplePly run() {
    readHeader();
    std::vector<uint8_t> vertices;
    size_t strip_faces = 0;
    for (size_t e = 0; e < needed_; ++e) {
      const Element& element = elements_[e];
      // Of other elements nothing is kept.
      out_ = element.name == "vertex" ? &vertices : &faces_;
      for (size_t i = 0; i < element.count; ++i) {
        if (&element == strips_) {
          strip_faces += cutStrips(element);
        } else {
          copyRow(element, &element == surface_);
        }
      }
    }
    SimplePly out;
    out_ = &out.bytes;
    add("ply\nformat " + std::string(format_) + " 1.0\n");
    for (const Element& element : elements_)
      if (element.name == "vertex") addElement(element, element.count, {});
    if (strips_) {
      addElement(*strips_, strip_faces, "uchar");
    } else {
      addElement(*surface_, surface_->count, {});
    }
    add("end_header\n");
    out.bytes.insert(out.bytes.end(), vertices.begin(), vertices.end());
    vertices = {};
    out.bytes.insert(out.bytes.end(), faces_.begin(), faces_.end());
    out.corner_uvs = std::move(corner_uvs_);
    out.textures = std::move(textures_);
    return out;
  }

 private:
  void add(std::string_view text) { out_->insert(out_->end(), text.begin(), text.end()); }

  // `counted`: the type of the counts of its lists, if not their own.
  void addElement(const Element& element, size_t count, std::string_view counted) {
    add("element " + std::string(element.name == "vertex" ? "vertex" : "face") + " " + std::to_string(count) +
        "\n");
    for (const Property& property : element.properties) {
      if (!property.kept) continue;
      add("property ");
      if (property.count)
        add("list " + std::string(counted.empty() ? property.count->count_name : counted) + " ");
      // By these names OpenMesh knows what MeshLab calls texture_u and texture_v.
      const size_t prefix = property.name.starts_with(kTexture) ? kTexture.size() : 0;
      add(std::string(property.as_float ? "float" : property.type->name) + " " +
          std::string(property.name.substr(prefix)) + "\n");
    }
  }

  std::string_view line() {
    const size_t end = rest_.find('\n');
    if (end == std::string_view::npos) fail("its header does not end");
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return line;
  }

  static std::string_view word(std::string_view& line) {
    while (!line.empty() && isSpace(line.front())) line.remove_prefix(1);
    const size_t end = static_cast<size_t>(std::find_if(line.begin(), line.end(), isSpace) - line.begin());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    return word;
  }

  static bool isKept(std::string_view element, const Property& property) {
    const auto one_of = [&](std::initializer_list<std::string_view> names) {
      return std::find(names.begin(), names.end(), property.name) != names.end();
    };
    if (element == "face" || element == "tristrips")
      return property.count && !property.type->count_name.empty() &&
             one_of({"vertex_indices", "vertex_index"});
    if (element != "vertex" || property.count) return false;
    const bool number = property.type->count_name.empty();
    if (one_of({"x", "y", "z"})) return true;
    if (one_of({"nx", "ny", "nz", "u", "v", "s", "t", "texture_u", "texture_v"})) return number;
    return one_of({"red", "green", "blue", "alpha", "diffuse_red", "diffuse_green", "diffuse_blue"}) &&
           (property.type->name == "uchar" || property.type->name == "float");
  }

  void readHeader() {
    line();
    for (;;) {
      std::string_view words = line();
      const std::string_view key = word(words);
      if (key == "end_header") break;
      if (key == "format") {
        format_ = word(words);
        if (format_ != "ascii" && format_ != "binary_little_endian" && format_ != "binary_big_endian")
          fail("its format \"" + std::string(format_.substr(0, 40)) + "\" is unknown");
      } else if (key == "element") {
        Element element{word(words), 0, {}};
        const std::string_view count = word(words);
        if (std::from_chars(count.data(), count.data() + count.size(), element.count).ec != std::errc())
          fail("its header has an element without a count");
        elements_.push_back(std::move(element));
      } else if (key == "property") {
        if (elements_.empty()) fail("its header has a property of no element");
        Property property;
        std::string_view type = word(words);
        if (type == "list") {
          property.count = &typeOf(word(words));
          if (property.count->count_name.empty()) fail("its header has a list whose count is no integer");
          type = word(words);
        }
        property.type = &typeOf(type);
        property.name = word(words);
        property.kept = isKept(elements_.back().name, property);
        property.as_float = property.kept && !property.type->count_name.empty() &&
                            (property.name == "x" || property.name == "y" || property.name == "z");
        elements_.back().properties.push_back(property);
      } else if (key == "comment") {
        if (word(words) == "TextureFile") textures_.emplace_back(trimmed(words));
      } else if (!key.empty() && key != "obj_info") {
        fail("its header has the unknown line \"" + std::string(key.substr(0, 40)) + "\"");
      }
    }
    if (format_.empty()) fail("its header names no format");
    for (const Element& element : elements_)
      if (element.properties.empty() && element.count > 0)
        fail("its header has an element without properties");
    findSurface();
  }

  void findSurface() {
    bool places = false;
    for (size_t e = 0; e < elements_.size(); ++e) {
      const Element& element = elements_[e];
      const auto keeps = [&](std::string_view name) {
        return std::any_of(element.properties.begin(), element.properties.end(),
                           [&](const Property& p) { return p.kept && (p.count || p.name == name); });
      };
      if (element.name == "vertex") {
        places = keeps("x") && keeps("y") && keeps("z");
      } else if (element.count > 0 && keeps({}) && !(surface_ && element.name == "tristrips")) {
        surface_ = &element;
      } else {
        continue;
      }
      needed_ = e + 1;
    }
    if (!places) fail("its header has no element \"vertex\" with x, y and z");
    if (!surface_) fail("it has no faces: it is a cloud of points");
    if (surface_->name == "tristrips") strips_ = surface_;
  }

  void copyRow(const Element& element, bool face) {
    size_t corners = 0;
    uvs_.clear();
    for (const Property& property : element.properties) {
      size_t values = 1;
      if (property.count) {
        const std::string_view count = value(*property.count);
        if (property.kept) copy(count);
        values = number(count);
        if (property.kept) corners = values;
      }
      const bool uvs =
          face && property.count && property.name == "texcoord" && property.type->count_name.empty();
      for (size_t i = 0; i < values; ++i) {
        const std::string_view next = value(*property.type);
        if (property.as_float && format_ != "ascii") {
          addFloat(whole(*property.type, next));
        } else if (property.kept) {
          copy(next);
        }
        if (uvs) uvs_.push_back(real(next));
      }
    }
    if (face && (!uvs_.empty() || !corner_uvs_.empty())) {
      uvs_.resize(2 * corners);
      corner_uvs_.resize(2 * corners_);
      corner_uvs_.insert(corner_uvs_.end(), uvs_.begin(), uvs_.end());
    }
    corners_ += corners;
    if (format_ == "ascii") out_->push_back('\n');
  }

  // Triangles of the strips of a row, which -1 parts. Returns how many.
  size_t cutStrips(const Element& element) {
    size_t triangles = 0;
    for (const Property& property : element.properties) {
      size_t values = 1;
      if (property.count) values = number(value(*property.count));
      std::string_view before[2];
      for (size_t i = 0, run = 0; i < values; ++i) {
        const std::string_view next = value(*property.type);
        if (!property.kept) continue;
        const bool end = format_ == "ascii" ? next == "-1" : next.find_first_not_of('\xFF') == next.npos;
        run = end ? 0 : run + 1;
        if (run > 2) {
          add(format_ == "ascii" ? "3 " : "\3");
          copy(before[(run + 1) % 2]);
          copy(before[run % 2]);
          copy(next);
          if (format_ == "ascii") out_->push_back('\n');
          ++triangles;
        }
        before[0] = before[1];
        before[1] = next;
      }
    }
    return triangles;
  }

  std::string_view value(const Type& type) {
    if (format_ == "ascii") {
      const std::string_view next = word(rest_);
      if (next.empty()) fail("cut off");
      return next;
    }
    if (rest_.size() < type.size) fail("cut off");
    const std::string_view next = rest_.substr(0, type.size);
    rest_.remove_prefix(type.size);
    return next;
  }

  void copy(std::string_view value) {
    add(value);
    if (format_ == "ascii") out_->push_back(' ');
  }

  void addFloat(float value) {
    const auto word = std::bit_cast<uint32_t>(value);
    for (uint32_t i = 0; i < 4; ++i)
      out_->push_back(static_cast<uint8_t>(word >> 8 * (format_ == "binary_little_endian" ? i : 3 - i)));
  }

  size_t number(std::string_view count) const {
    size_t value = 0;
    if (format_ == "ascii") {
      if (std::from_chars(count.data(), count.data() + count.size(), value).ec != std::errc())
        fail("a list has no count");
      return value;
    }
    return bits(count);
  }

  float real(std::string_view value) const {
    if (format_ == "ascii") {
      float number = 0.0f;
      std::from_chars(value.data(), value.data() + value.size(), number);
      return number;
    }
    if (value.size() == sizeof(float)) return std::bit_cast<float>(static_cast<uint32_t>(bits(value)));
    return static_cast<float>(std::bit_cast<double>(bits(value)));
  }

  float whole(const Type& type, std::string_view value) const {
    const size_t unused = 64 - 8 * value.size();
    const uint64_t high = bits(value) << unused;
    return type.name.starts_with('u') ? static_cast<float>(high >> unused)
                                      : static_cast<float>(static_cast<int64_t>(high) >> unused);
  }

  uint64_t bits(std::string_view value) const {
    uint64_t bits = 0;
    for (size_t i = 0; i < value.size(); ++i)
      bits |=
          uint64_t{static_cast<uint8_t>(value[format_ == "binary_little_endian" ? i : value.size() - 1 - i])}
          << (8 * i);
    return bits;
  }

  std::string_view rest_, format_;
  std::vector<std::string> textures_;
  std::vector<Element> elements_;
  size_t needed_ = 0;                 // elements up to the last one that is needed
  const Element* surface_ = nullptr;  // the faces
  const Element* strips_ = nullptr;   // surface_, if it is triangle strips
  std::vector<uint8_t> faces_;
  std::vector<uint8_t>* out_ = nullptr;
  std::vector<float> uvs_, corner_uvs_;  // of a face; of all faces so far
  size_t corners_ = 0;                   // so far
};

}  // namespace

SimplePly simplePly(const std::vector<uint8_t>& bytes) {
  return Simplifier({reinterpret_cast<const char*>(bytes.data()), bytes.size()}).run();
}

std::vector<std::string> plyTextures(const std::vector<uint8_t>& bytes) {
  return Simplifier({reinterpret_cast<const char*>(bytes.data()), bytes.size()}).textures();
}

}  // namespace furrow::pipeline
