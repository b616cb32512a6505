#pragma once

// What the editor remembers from one start to the next.

#include <filesystem>
#include <string>
#include <vector>

namespace furrow::editor {

struct Settings {
  std::vector<std::filesystem::path> recent;  // files opened, the latest first, at most kMostRecent
  int width = 1440, height = 900;             // of the window, in screen units
  float scale = 0.0f;                         // of text and widgets, [0.5, 4]; 0: what the screen asks for
  std::string tier = "auto";                  // "auto", "gpu", "gpu-raster" or "cpu"
  int painted_size = 1024;                    // texels a side of a new painted image: 256 to 4096
  bool show_left = true, show_right = true;
  float left_width = 21.5f, right_width = 21.5f;  // of the panels, in heights of the text
  std::filesystem::path folder;                   // that the file dialog showed last

  static constexpr size_t kMostRecent = 10;
  static constexpr int kLeastWidth = 640, kLeastHeight = 480;  // smaller windows leave no view
  static constexpr float kLeastPanel = 12.0f, kMostPanel = 60.0f;
  void opened(const std::filesystem::path& file);
};

// $XDG_CONFIG_HOME/furrow/editor.json, or below ~/.config.
std::filesystem::path settingsFile();

// Values that are missing, damaged or out of range are the defaults.
Settings readSettings(const std::filesystem::path& file);
// Throws pipeline::Error (kEnvironment).
void writeSettings(const std::filesystem::path& file, const Settings& settings);

}  // namespace furrow::editor
