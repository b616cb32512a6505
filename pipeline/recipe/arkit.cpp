#include "pipeline/recipe/arkit.h"

#include <cctype>
#include <string_view>

namespace furrow::pipeline {
namespace {

struct Crease {
  const char* region;
  const char* shape;
  bool sided;  // there are two of the shape, Left and Right
  double gain;
};

// Which muscle creases what: frontalis, corrugator, orbicularis oculi, levator labii, zygomaticus,
// orbicularis oris, mentalis.
constexpr Crease kCreases[] = {
    {"forehead", "browInnerUp", false, 0.6},  {"forehead", "browOuterUp", true, 0.4},
    {"glabella", "browDown", true, 1.0},      {"crowsFeet", "eyeSquint", true, 0.7},
    {"crowsFeet", "cheekSquint", true, 0.3},  {"bunny", "noseSneer", true, 1.0},
    {"nasolabial", "mouthSmile", true, 0.7},  {"nasolabial", "noseSneer", true, 0.3},
    {"nasolabial", "cheekSquint", true, 0.3}, {"mouth", "mouthPucker", false, 1.0},
    {"mouth", "mouthFunnel", false, 0.5},     {"chin", "mouthShrugLower", false, 1.0},
    {"chin", "mouthFrown", true, 0.4},
};
constexpr const char* kPrefix = "arkit:";
constexpr const char* kSides[] = {"", "Left", "Right"};
constexpr size_t kShortestShape = 6;  // of letters; what stands behind a dot and is shorter is a side

// Lower case, no prefix, no separators, sides as one letter.
std::string keyOf(std::string_view name) {
  const size_t dot = name.find_last_of(".:");
  if (dot != std::string_view::npos && name.size() - dot > kShortestShape) name.remove_prefix(dot + 1);
  std::string key;
  for (char c : name)
    if (c != '_' && c != '-' && c != '.' && c != ' ')
      key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (std::string_view side : {"left", "right"})
    if (key.size() > side.size() && key.ends_with(side)) return key.substr(0, key.size() - side.size() + 1);
  return key;
}

}  // namespace

std::vector<size_t> matchShape(const std::vector<std::string>& names, const std::string& shape) {
  std::vector<size_t> equal, alike, sides;
  const std::string key = keyOf(shape);
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string other = keyOf(names[i]);
    if (names[i] == shape) equal.push_back(i);
    if (other == key) alike.push_back(i);
    if (other == key + 'l' || other == key + 'r') sides.push_back(i);
  }
  return !equal.empty() ? equal : !alike.empty() ? alike : sides;
}

std::vector<std::string> driverTables() {
  std::vector<std::string> tables;
  for (size_t i = 0; i < std::size(kCreases); ++i)
    if (i == 0 || std::string_view(kCreases[i].region) != kCreases[i - 1].region)
      for (const char* side : kSides) tables.push_back(kPrefix + std::string(kCreases[i].region) + side);
  return tables;
}

std::vector<std::pair<std::string, double>> driverTable(const std::string& name) {
  std::vector<std::pair<std::string, double>> shapes;
  for (const Crease& crease : kCreases)
    for (size_t side = 0; side < std::size(kSides); ++side) {
      if (name != kPrefix + std::string(crease.region) + kSides[side]) continue;
      const std::string shape = crease.shape;
      if (!crease.sided)
        shapes.emplace_back(shape, crease.gain);
      else if (side != 0)
        shapes.emplace_back(shape + kSides[side], crease.gain);
      else
        for (size_t half : {1, 2}) shapes.emplace_back(shape + kSides[half], 0.5 * crease.gain);
    }
  return shapes;
}

}  // namespace furrow::pipeline
