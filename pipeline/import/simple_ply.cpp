#include "pipeline/import/simple_ply.h"

#include <algorithm>
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
};

struct Element {
  std::string_view name;
  size_t count = 0;
  std::vector<Property> properties;
};

bool isSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

class Simplifier {
 public:
  explicit Simplifier(std::string_view bytes) : rest_(bytes) {}

  std::vector<uint8_t> run() {
    readHeader();
    add("ply\nformat " + std::string(format_) + " 1.0\n");
    bool faces = false;
    for (const Element& element : elements_) {
      if (element.name != "vertex" && element.name != "face") continue;
      add("element " + std::string(element.name) + " " + std::to_string(element.count) + "\n");
      for (const Property& property : element.properties) {
        if (!property.kept) continue;
        add("property ");
        if (property.count) add("list " + std::string(property.count->count_name) + " ");
        add(std::string(property.type->name) + " " + std::string(property.name) + "\n");
        faces |= property.count && element.count > 0;
      }
    }
    if (!faces) fail("it has no faces: it is a cloud of points");
    add("end_header\n");
    for (const Element& element : elements_) {
      for (size_t i = 0; i < element.count; ++i) copyRow(element);
      if (element.name == "face") break;  // nothing is needed of what follows
    }
    return std::move(out_);
  }

 private:
  void add(std::string_view text) { out_.insert(out_.end(), text.begin(), text.end()); }

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
    if (element == "face")
      return property.count && !property.type->count_name.empty() &&
             one_of({"vertex_indices", "vertex_index"});
    if (element != "vertex" || property.count) return false;
    const bool number = property.type->count_name.empty();
    if (one_of({"x", "y", "z"}) && !number) fail("its positions are integers");
    if (one_of({"x", "y", "z", "nx", "ny", "nz", "u", "v", "s", "t"})) return number;
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
        elements_.back().properties.push_back(property);
      } else if (!key.empty() && key != "comment" && key != "obj_info") {
        fail("its header has the unknown line \"" + std::string(key.substr(0, 40)) + "\"");
      }
    }
    if (format_.empty()) fail("its header names no format");
    for (const Element& element : elements_)
      if (element.properties.empty() && element.count > 0)
        fail("its header has an element without properties");
  }

  void copyRow(const Element& element) {
    for (const Property& property : element.properties) {
      size_t values = 1;
      if (property.count) {
        const std::string_view count = value(*property.count);
        if (property.kept) copy(count);
        values = number(count);
      }
      for (size_t i = 0; i < values; ++i) {
        const std::string_view next = value(*property.type);
        if (property.kept) copy(next);
      }
    }
    if (format_ == "ascii") out_.push_back('\n');
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
    if (format_ == "ascii") out_.push_back(' ');
  }

  size_t number(std::string_view count) const {
    size_t value = 0;
    if (format_ == "ascii") {
      if (std::from_chars(count.data(), count.data() + count.size(), value).ec != std::errc())
        fail("a list has no count");
      return value;
    }
    for (size_t i = 0; i < count.size(); ++i)
      value |=
          size_t{static_cast<uint8_t>(count[format_ == "binary_little_endian" ? i : count.size() - 1 - i])}
          << (8 * i);
    return value;
  }

  std::string_view rest_, format_;
  std::vector<Element> elements_;
  std::vector<uint8_t> out_;
};

}  // namespace

std::vector<uint8_t> simplePly(const std::vector<uint8_t>& bytes) {
  return Simplifier({reinterpret_cast<const char*>(bytes.data()), bytes.size()}).run();
}

}  // namespace furrow::pipeline
