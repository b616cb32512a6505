#pragma once

// Small glTF files, made in memory and written where a test can read them.

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace furrow::test {

inline std::filesystem::path writeFile(const std::string& name, const std::string& bytes) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / name;
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

template <typename T>
constexpr int kComponentType = 5126;
template <>
inline constexpr int kComponentType<int8_t> = 5120;
template <>
inline constexpr int kComponentType<uint8_t> = 5121;
template <>
inline constexpr int kComponentType<int16_t> = 5122;
template <>
inline constexpr int kComponentType<uint16_t> = 5123;
template <>
inline constexpr int kComponentType<uint32_t> = 5125;

class GltfBuilder {
 public:
  // Returns the number of the view.
  template <typename T>
  int addView(const std::vector<T>& values) {
    while (bin_.size() % 4 != 0) bin_.push_back('\0');
    const size_t begin = bin_.size();
    bin_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    append(views_, "{\"buffer\":0,\"byteOffset\":" + std::to_string(begin) +
                       ",\"byteLength\":" + std::to_string(bin_.size() - begin) + "}");
    return view_count_++;
  }

  // Adds a view with the values and an accessor on it; returns the number of the accessor.
  template <typename T>
  int add(const std::vector<T>& values, const std::string& type, size_t components,
          const std::string& more = "") {
    const int view = addView(values);
    return addAccessor(
        "\"bufferView\":" + std::to_string(view) + ",\"componentType\":" + std::to_string(kComponentType<T>) +
        ",\"count\":" + std::to_string(values.size() / components) + ",\"type\":\"" + type + "\"" + more);
  }

  int addAccessor(const std::string& members) {
    append(accessors_, "{" + members + "}");
    return accessor_count_++;
  }

  std::string json(const std::string& members, const std::string& buffer_uri = "") const {
    std::string buffer = "{\"byteLength\":" + std::to_string(bin_.size());
    if (!buffer_uri.empty()) buffer += ",\"uri\":\"" + buffer_uri + "\"";
    return "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[" + buffer + "}],\"bufferViews\":[" + views_ +
           "],\"accessors\":[" + accessors_ + "]" + (members.empty() ? "" : "," + members) + "}";
  }

  std::string glb(const std::string& members) const {
    std::string text = json(members);
    while (text.size() % 4 != 0) text.push_back(' ');
    std::string bin = bin_;
    while (bin.size() % 4 != 0) bin.push_back('\0');
    return "glTF" + u32(2) + u32(28 + text.size() + bin.size()) + u32(text.size()) + "JSON" + text +
           u32(bin.size()) + std::string("BIN\0", 4) + bin;
  }

  const std::string& bin() const { return bin_; }

 private:
  static void append(std::string& list, const std::string& entry) {
    list += (list.empty() ? "" : ",") + entry;
  }
  static std::string u32(size_t value) {
    const uint32_t word = static_cast<uint32_t>(value);
    std::string out(4, '\0');
    std::memcpy(out.data(), &word, 4);
    return out;
  }

  std::string bin_, views_, accessors_;
  int view_count_ = 0, accessor_count_ = 0;
};

}  // namespace furrow::test
