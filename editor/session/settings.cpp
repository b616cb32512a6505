#include "editor/session/settings.h"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"

namespace furrow::editor {
namespace {

using json = nlohmann::ordered_json;

std::string text(const std::filesystem::path& path) {
  const std::u8string utf8 = path.generic_u8string();
  return {utf8.begin(), utf8.end()};
}

std::filesystem::path path(const std::string& text) {
  return std::u8string(text.begin(), text.end());
}

template <typename T>
void read(const json& from, const char* key, T& value, T low, T high) {
  const auto found = from.find(key);
  if (found == from.end() || !found->is_number()) return;
  const T number = found->get<T>();
  if (number >= low && number <= high) value = number;
}

void read(const json& from, const char* key, bool& value) {
  if (const auto found = from.find(key); found != from.end() && found->is_boolean())
    value = found->get<bool>();
}

}  // namespace

void Settings::opened(const std::filesystem::path& file) {
  const std::filesystem::path whole = std::filesystem::absolute(file).lexically_normal();
  std::erase(recent, whole);
  recent.insert(recent.begin(), whole);
  if (recent.size() > kMostRecent) recent.resize(kMostRecent);
  folder = whole.parent_path();
}

std::filesystem::path settingsFile() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  const char* home = std::getenv("HOME");
  const std::filesystem::path base = config && *config ? std::filesystem::path(config)
                                     : home            ? std::filesystem::path(home) / ".config"
                                                       : std::filesystem::path(".");
  return base / "furrow" / "editor.json";
}

Settings readSettings(const std::filesystem::path& file) {
  Settings settings;
  std::ifstream in(file, std::ios::binary);
  const json from = json::parse(in, nullptr, false);
  if (!from.is_object()) return settings;
  if (const auto recent = from.find("recent"); recent != from.end() && recent->is_array())
    for (const json& entry : *recent)
      if (entry.is_string() && settings.recent.size() < Settings::kMostRecent)
        settings.recent.push_back(path(entry.get<std::string>()));
  read(from, "width", settings.width, Settings::kLeastWidth, 16384);
  read(from, "height", settings.height, Settings::kLeastHeight, 16384);
  read(from, "scale", settings.scale, 0.5f, 4.0f);
  if (const auto tier = from.find("tier"); tier != from.end() && tier->is_string())
    for (const char* known : {"auto", "gpu", "gpu-raster", "cpu"})
      if (*tier == known) settings.tier = known;
  read(from, "paintedSize", settings.painted_size, 256, 4096);
  read(from, "showLeft", settings.show_left);
  read(from, "showRight", settings.show_right);
  read(from, "leftWidth", settings.left_width, Settings::kLeastPanel, Settings::kMostPanel);
  read(from, "rightWidth", settings.right_width, Settings::kLeastPanel, Settings::kMostPanel);
  if (const auto folder = from.find("folder"); folder != from.end() && folder->is_string())
    settings.folder = path(folder->get<std::string>());
  return settings;
}

void writeSettings(const std::filesystem::path& file, const Settings& settings) {
  json to;
  to["recent"] = json::array();
  for (const std::filesystem::path& entry : settings.recent) to["recent"].push_back(text(entry));
  to["width"] = settings.width;
  to["height"] = settings.height;
  to["scale"] = settings.scale;
  to["tier"] = settings.tier;
  to["paintedSize"] = settings.painted_size;
  to["showLeft"] = settings.show_left;
  to["showRight"] = settings.show_right;
  to["leftWidth"] = settings.left_width;
  to["rightWidth"] = settings.right_width;
  to["folder"] = text(settings.folder);
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  const std::string written = to.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
  pipeline::writeFile(file, std::as_bytes(std::span(written)));
}

}  // namespace furrow::editor
