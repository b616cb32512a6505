#pragma once

// What JSON that people write may hold: recipes and manifests. One description of its keys serves the reader,
// which checks files against it, and the documentation, which is written from it.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace furrow::pipeline {

struct JsonKey;

// Bounds that a reader need not be told of.
inline constexpr double kLength = 1e9;   // of the scene's unit
inline constexpr double kMany = 100000;  // items of a list

// What one value may be.
struct JsonShape {
  enum class Kind {
    kText,     // a string that is not empty
    kName,     // the same, fit for a column of a CSV file: no comma, quote or control character
    kFile,     // the path of a file that exists, relative to the JSON file
    kImage,    // the same, or an image in a glTF file, see embeddedImage()
    kWord,     // one of `words`
    kNumber,   // [min, max], or (min, max] if above_min
    kInteger,  // [min, max]
    kList,     // [min, max] values of shape inner[0]
    kObject,   // `keys`, and no other
    kMap,      // any keys, values of shape inner[0]
    kEither,   // one of `inner`, which a JSON value's type tells apart
  };

  Kind kind = Kind::kText;
  std::vector<std::string> words;
  double min = 0.0, max = 0.0;
  bool above_min = false;
  std::vector<JsonShape> inner;
  std::vector<JsonKey> keys;
  std::string meaning;             // what to give, in words; empty: what the kind says
  std::vector<std::string> forms;  // names of keys of which exactly one must be there; empty: no such rule
};

struct JsonKey {
  std::string name;
  JsonShape shape;
  std::string doc;
  bool required = false;
  std::string form = {};  // if not empty, the key may only stand beside this one
};

// What to give where `shape` is asked for, in words.
std::string describe(const JsonShape& shape);

struct JsonFile {
  nlohmann::json value;                      // fits the shape
  std::vector<std::filesystem::path> files;  // that a kFile or kImage in it is read from, absolute
};

// Reads `file`, in which comments are allowed; `kind` is the word for it in messages, "recipe". Throws Error
// (kBadData), whose message names `file` and the place in it: it cannot be opened, is not JSON (line and
// column), has a key twice in one object, or does not fit the shape (the path of the key at fault, such as
// layers[0].response.beta).
JsonFile readJson(const std::filesystem::path& file, const JsonShape& shape, const char* kind);

// The same of a text that is in memory, as if it stood in `file`.
JsonFile parseJson(const std::string& text, const std::filesystem::path& file, const JsonShape& shape,
                   const char* kind);

// `text`, written in `file`, as a path.
std::filesystem::path pathIn(const std::filesystem::path& file, const std::string& text);

// The shape as a JSON Schema (draft 7).
std::string schemaText(const JsonShape& shape, const char* title);

}  // namespace furrow::pipeline
