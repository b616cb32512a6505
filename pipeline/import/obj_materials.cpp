#include "pipeline/import/obj_materials.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/input_file.h"

namespace furrow::pipeline {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr float kLargestNumber = 1e6f;  // beyond which nobody scales or shifts an image

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

// The first word, which `text` loses.
std::string_view word(std::string_view& text) {
  text = trimmed(text);
  const std::string_view first = text.substr(0, text.find_first_of(kSpace));
  text = trimmed(text.substr(first.size()));
  return first;
}

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

// A number that is a whole word, which `text` loses.
std::optional<float> number(std::string_view& text) {
  std::string_view rest = text;
  const std::string_view first = word(rest);
  float value = 0.0f;
  const auto [end, error] = std::from_chars(first.data(), first.data() + first.size(), value);
  if (error != std::errc() || end != first.data() + first.size() || !(std::abs(value) <= kLargestNumber))
    return std::nullopt;
  text = rest;
  return value;
}

class MtlReader {
 public:
  MtlReader(const std::filesystem::path& file, const std::filesystem::path& model, ObjMaterials& out)
      : folders_{file.parent_path(), model.parent_path()}, out_(out) {}

  void read(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    while (!text.empty()) {
      std::string_view line = text.substr(0, text.find_first_of("\r\n"));
      text.remove_prefix(std::min(line.size() + 1, text.size()));
      const std::string key = lowerCase(word(line));
      if (key == "newmtl") {
        finish();
        material_ = &(out_.materials[std::string(line)] = Material());
        name_ = line;
        opacity_ = {};
      } else if (material_ && !line.empty()) {
        readLine(key, line);
      }
    }
    finish();
  }

 private:
  void readLine(const std::string& key, std::string_view line) {
    MaterialMaps& maps = material_->maps;
    if (key == "kd") {
      for (int c = 0; c < 3 && maps.color.image == kNoIndex; ++c)
        if (const auto value = number(line)) material_->base_color[c] = std::clamp(*value, 0.0f, 1.0f);
    } else if (key == "pr") {
      if (const auto value = number(line)) material_->roughness = std::clamp(*value, 0.0f, 1.0f);
    } else if (key == "map_kd") {
      // Many exporters leave a grey or black Kd beside the image.
      material_->base_color = glm::vec4(glm::vec3(1.0f), material_->base_color.a);
      maps.color = readMap(line);
    } else if (key == "d" || key == "tr") {
      // Exporters disagree about which end of "Tr" is clear; nobody means a material that is not there.
      const float value = number(line).value_or(1.0f), opacity = key == "d" ? value : 1.0f - value;
      if (opacity > 0.0f && opacity < 1.0f) material_->base_color.a = opacity;
    } else if (key == "map_d") {
      opacity_ = readMap(line);
    } else if (key == "norm" || ((key == "map_bump" || key == "bump") && maps.normal.image == kNoIndex)) {
      maps.normal = readMap(line, &maps.normal_scale);
    }
  }

  // Puts a material's opacity to its colour.
  void finish() {
    if (!material_ || opacity_.image == kNoIndex) return;
    MaterialMaps& maps = material_->maps;
    if (maps.color.image == kNoIndex) {
      maps.color = opacity_;
      maps.color.image = kNoIndex;
    }
    if (maps.color.image != opacity_.image) {
      if (maps.color.uv != opacity_.uv || maps.color.wrap != opacity_.wrap) {
        out_.warnings.push_back(
            "material \"" + name_ + "\": its opacity texture " + out_.images[opacity_.image].name +
            " is left out: it is not placed as its colour is: give both the same options");
        return;
      }
      maps.opacity = opacity_.image;
    }
    maps.opaque_from = kBlendCutoff * material_->base_color.a;
  }

  struct Options {
    float scale[3] = {1.0f, 1.0f, 1.0f}, offset[3] = {}, bump = 1.0f;
    bool clamp = false;
  };

  // `line` loses them, and keeps a name, which may have spaces.
  static Options readOptions(std::string_view& line) {
    Options options;
    const auto numbers = [&](float* values) {
      for (int i = 0; i < 3; ++i) {
        const auto value = number(line);
        if (!value) break;
        values[i] = *value;
      }
    };
    while (line.starts_with('-')) {
      const std::string option = lowerCase(word(line));
      float unused[3];
      if (option == "-s") {
        numbers(options.scale);
      } else if (option == "-o") {
        numbers(options.offset);
      } else if (option == "-t" || option == "-mm") {
        numbers(unused);
      } else if (option == "-bm") {
        options.bump = number(line).value_or(1.0f);
      } else if (option == "-clamp") {
        options.clamp = lowerCase(word(line)) == "on";
      } else {
        word(line);  // -blendu, -blendv, -boost, -cc, -imfchan, -texres, -type
      }
    }
    return options;
  }

  MaterialMap readMap(std::string_view line, float* bump = nullptr) {
    const auto [scale, offset, strength, clamp] = readOptions(line);
    MaterialMap map;
    if (line.empty()) return map;
    if (bump) *bump = strength;
    // Theirs count v from the bottom of the image, ours from the top.
    map.uv = glm::mat3x2(scale[0], 0.0f, 0.0f, scale[1], offset[0], 1.0f - scale[1] - offset[1]);
    if (clamp) map.wrap.fill(Wrap::kClamp);
    const std::filesystem::path file = findFile(line, folders_);
    const auto known = std::ranges::find(out_.images, file, &SourceImage::file);
    map.image = static_cast<uint32_t>(known - out_.images.begin());
    if (known == out_.images.end()) out_.images.push_back({file.filename().string(), file, {}});
    return map;
  }

  std::vector<std::filesystem::path> folders_;
  ObjMaterials& out_;
  Material* material_ = nullptr;
  std::string name_;     // of the material
  MaterialMap opacity_;  // as map_d has it
};

}  // namespace

std::filesystem::path findFile(std::string_view name, const std::vector<std::filesystem::path>& folders) {
  if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  std::error_code ignored;
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path led = namedFile(name, folder);
    for (const std::filesystem::path& file : {led, folder / led.filename()})
      if (std::filesystem::is_regular_file(file, ignored)) return file;
  }
  return namedFile(name, folders.front());
}

void addMaterials(std::string_view text, const std::filesystem::path& file,
                  const std::filesystem::path& model, ObjMaterials& out) {
  MtlReader(file, model, out).read(text);
}

ObjMaterials readObjMaterials(const std::filesystem::path& model, const std::vector<std::string>& libraries) {
  ObjMaterials out;
  const auto inFolder = [&](std::string_view name) { return findFile(name, {model.parent_path()}); };
  const auto read = [&](std::string_view name) {
    const std::filesystem::path file = inFolder(name);
    if (std::ranges::find(out.files, file) != out.files.end()) return;
    try {
      const std::vector<uint8_t> bytes = readBytes(file);
      out.files.push_back(file);
      addMaterials({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file, model, out);
    } catch (const Error& error) {
      if (error.exit() == Exit::kEnvironment) throw;
      out.warnings.push_back(std::string("its materials are shown without colours: ") + error.what());
    }
  };
  for (const std::string& names : libraries) {
    std::string_view rest = names;
    std::error_code ignored;
    const bool several = !std::filesystem::is_regular_file(inFolder(rest), ignored) &&
                         lowerCase(rest).find(".mtl ") != std::string::npos;
    while (!rest.empty()) read(several ? word(rest) : std::exchange(rest, {}));
  }
  return out;
}

}  // namespace furrow::pipeline
