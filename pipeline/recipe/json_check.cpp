#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/input_file.h"
#include "pipeline/recipe/json_shape.h"

namespace furrow::pipeline {

namespace {

using json = nlohmann::json;
using Shape = JsonShape;
using Kind = JsonShape::Kind;

std::string inQuotes(const std::string& text) {
  return '"' + text + '"';
}

std::string joined(const std::vector<std::string>& parts, const char* last) {
  std::string result;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (i != 0) result += i + 1 == parts.size() ? last : ", ";
    result += parts[i];
  }
  return result;
}

std::string quotedList(std::vector<std::string> names) {
  for (std::string& name : names) name = inQuotes(name);
  return joined(names, " or ");
}

std::string plain(double number) {
  return number == std::floor(number) && std::abs(number) < 1e15
             ? std::to_string(static_cast<int64_t>(number))
             : json(number).dump();
}

std::string shown(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list of " + std::to_string(value.size());
  std::string text = value.dump(-1, ' ', true);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

bool hasType(const json& value, const Shape& shape) {
  switch (shape.kind) {
    case Kind::kText:
    case Kind::kName:
    case Kind::kFile:
    case Kind::kImage:
    case Kind::kWord:
      return value.is_string();
    case Kind::kNumber:
    case Kind::kInteger:
      return value.is_number();
    case Kind::kList:
      return value.is_array();
    case Kind::kObject:
    case Kind::kMap:
      return value.is_object();
    case Kind::kEither:
      return std::any_of(shape.inner.begin(), shape.inner.end(),
                         [&](const Shape& s) { return hasType(value, s); });
  }
  return false;
}

size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      size_t change = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Finds what json::parse() leaves out: where an error is, and keys that stand twice.
class SyntaxCheck : public nlohmann::json_sax<json> {
 public:
  SyntaxCheck(const std::string& text, const std::filesystem::path& file, const std::string& kind)
      : text_(text), file_(file), kind_(kind) {}

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_array(size_t) override { return open(); }
  bool end_array() override { return close(); }
  bool start_object(size_t) override { return open(); }
  bool end_object() override { return close(); }

  bool key(string_t& name) override {
    if (!keys_.back().insert(name).second)
      throw Error(Exit::kBadData, file_.string(), "the key \"" + name + "\" stands twice in one object",
                  "keep one");
    return true;
  }

  bool parse_error(size_t position, const std::string& token,
                   const nlohmann::detail::exception& error) override {
    size_t end = std::min(position == 0 ? 0 : position - 1, text_.size());
    auto before = text_.begin() + static_cast<std::ptrdiff_t>(end);
    auto line = 1 + std::count(text_.begin(), before, '\n');
    size_t line_begin = text_.rfind('\n', end == 0 ? 0 : end - 1);
    size_t column = end - (line == 1 ? 0 : line_begin + 1) + 1;
    // The library's own text is "[json.exception...] parse error at line ..., column ...: what"; a number out
    // of range has none of that.
    std::string what = error.what();
    size_t colon = what.find(": ");
    what = colon == std::string::npos ? "the number " + token + " is too large" : what.substr(colon + 2);
    std::replace_if(
        what.begin(), what.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
    const size_t last = end == 0 ? std::string::npos : text_.find_last_not_of(" \t\r\n", end - 1);
    std::string remedy = "a " + kind_ + " is JSON, in which comments are allowed";
    if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF")) {
      what = "it is UTF-16";
      remedy = "save it as UTF-8";
    } else if (what.find("ill-formed UTF-8") != std::string::npos) {
      what = "it is not UTF-8";
      remedy = "save it as UTF-8";
    } else if (text_.find_first_not_of(" \t\r\n\xEF\xBB\xBF") == std::string::npos) {
      what = "nothing stands in it";
    } else if (what.find("object key - invalid literal") != std::string::npos) {
      remedy = "put keys and texts in double quotes";
    } else if (what.find("backslash") != std::string::npos) {
      remedy = "write paths with /";
    } else if (end < text_.size() && (text_[end] == ']' || text_[end] == '}') && last != std::string::npos &&
               text_[last] == ',') {
      what = std::string("nothing follows the comma before ") + text_[end];
      remedy = "take the comma out";
    }
    throw Error(Exit::kBadData, file_.string(),
                "line " + std::to_string(line) + ", column " + std::to_string(column) + ": " + what, remedy);
  }

 private:
  static constexpr size_t kMaxDepth = 64;

  bool open() {
    if (keys_.size() == kMaxDepth)
      throw Error(Exit::kBadData, file_.string(), "is nested too deeply",
                  "a " + kind_ + " nests a few levels");
    keys_.emplace_back();
    return true;
  }
  bool close() {
    keys_.pop_back();
    return true;
  }

  const std::string& text_;
  const std::filesystem::path& file_;
  const std::string& kind_;
  std::vector<std::set<std::string>> keys_;
};

class Checker {
 public:
  Checker(const std::filesystem::path& file, const std::string& kind, const Shape& whole)
      : file_(file), kind_(kind), whole_(whole) {}

  std::vector<std::filesystem::path> files;  // that were met

  void check(const json& value) { check(value, whole_, ""); }

 private:
  void check(const json& value, const Shape& shape, const std::string& path) {
    if (!hasType(value, shape)) failValue(value, shape, path);
    switch (shape.kind) {
      case Kind::kText:
        if (value.get_ref<const std::string&>().empty()) failValue(value, shape, path);
        break;
      case Kind::kName: {
        const auto& name = value.get_ref<const std::string&>();
        bool bad = std::any_of(name.begin(), name.end(), [](char c) {
          return c == ',' || c == '"' || c == 0x7f || static_cast<unsigned char>(c) < 0x20;
        });
        if (bad || name.empty()) failValue(value, shape, path);
        break;
      }
      case Kind::kFile:
      case Kind::kImage:
        checkFile(value, shape, path);
        break;
      case Kind::kWord:
        if (!contains(shape.words, value.get_ref<const std::string&>())) failValue(value, shape, path);
        break;
      case Kind::kInteger:
      case Kind::kNumber: {
        double number = value.get<double>();
        if (!(number >= shape.min && number <= shape.max) || (shape.above_min && number == shape.min) ||
            (shape.kind == Kind::kInteger && !value.is_number_integer()))
          failValue(value, shape, path);
        break;
      }
      case Kind::kList: {
        double count = static_cast<double>(value.size());
        if (count < shape.min || count > shape.max) failValue(value, shape, path);
        for (size_t i = 0; i < value.size(); ++i)
          check(value[i], shape.inner[0], path + '[' + std::to_string(i) + ']');
        break;
      }
      case Kind::kMap:
        for (const auto& [name, item] : value.items()) check(item, shape.inner[0], below(path, name));
        break;
      case Kind::kObject:
        checkObject(value, shape, path);
        break;
      case Kind::kEither:
        checkEither(value, shape, path);
        break;
    }
  }

  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& remedy) const {
    throw Error(Exit::kBadData, file_.string(), path.empty() ? wrong : path + ": " + wrong, remedy);
  }
  [[noreturn]] void failValue(const json& value, const Shape& shape, const std::string& path) {
    fail(path, path.empty() ? "the " + kind_ + " is " + shown(value) : "is " + shown(value),
         "give " + describe(shape));
  }

  static std::string below(const std::string& path, const std::string& key) {
    return path.empty() ? key : path + '.' + key;
  }

  void checkFile(const json& value, const Shape& shape, const std::string& path) {
    const auto& name = value.get_ref<const std::string&>();
    if (name.empty() || name.find('\0') != std::string::npos) failValue(value, shape, path);
    std::filesystem::path found = pathIn(file_, name);
    if (const auto embedded = shape.kind == Kind::kImage ? embeddedImage(found) : std::nullopt) {
      files.insert(files.end(), embedded->files.begin(), embedded->files.end());
      return;
    }
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(found, ignored))
      fail(
          path, "no such file " + found.string(),
          name.find('\\') == std::string::npos ? "paths are relative to the " + kind_ : "write paths with /");
    files.push_back(std::move(found));
  }

  // A string that is none of the words is judged by all alternatives, so that the message names them all.
  void checkEither(const json& value, const Shape& shape, const std::string& path) {
    for (const Shape& s : shape.inner) {
      if (!hasType(value, s)) continue;
      if (s.kind == Kind::kWord && !contains(s.words, value.get_ref<const std::string&>()))
        failValue(value, shape, path);
      return check(value, s, path);
    }
  }

  void checkObject(const json& value, const Shape& shape, const std::string& path) {
    for (const auto& [name, item] : value.items()) {
      if (std::none_of(shape.keys.begin(), shape.keys.end(),
                       [&, &n = name](const JsonKey& k) { return k.name == n; }))
        failUnknown(name, shape, path);
    }
    if (!shape.forms.empty()) {
      std::vector<std::string> given;
      for (const std::string& form : shape.forms)
        if (value.contains(form)) given.push_back(form);
      if (given.empty()) fail(path, "says nothing", "give " + describe(shape));
      if (given.size() > 1)
        fail(path, "has both " + inQuotes(given[0]) + " and " + inQuotes(given[1]), "give one of them");
      for (const JsonKey& key : shape.keys)
        if (!key.form.empty() && key.form != given[0] && value.contains(key.name))
          fail(below(path, key.name), "does not go with " + inQuotes(given[0]),
               "it goes with " + inQuotes(key.form));
    }
    for (const JsonKey& key : shape.keys) {
      auto found = value.find(key.name);
      if (found != value.end())
        check(*found, key.shape, below(path, key.name));
      else if (key.required)
        fail(below(path, key.name), "is missing", "give " + describe(key.shape));
    }
  }

  [[noreturn]] void failUnknown(const std::string& name, const Shape& shape, const std::string& path) {
    std::vector<KnownKey> known;
    for (const JsonKey& key : shape.keys) known.push_back({key.name, ""});
    addKeys(whole_, "", known);
    const auto distance = [&](const KnownKey& key) { return editDistance(name, key.name); };
    const KnownKey nearest = *std::ranges::min_element(known, {}, distance);
    if (nearest.place.empty())
      fail(below(path, name), "no such key", "did you mean " + inQuotes(nearest.name) + "?");
    std::vector<std::string> places;
    for (const KnownKey& key : known)
      if (key.name == nearest.name && !contains(places, key.place)) places.push_back(key.place);
    const std::string belongs = " belongs to " + joined(places, " or ");
    fail(below(path, name), "no such key",
         nearest.name == name ? "it" + belongs
                              : "did you mean " + inQuotes(nearest.name) + ", which" + belongs + '?');
  }

  struct KnownKey {
    std::string name, place;
  };

  // All keys of a shape at `path`, and where they may stand.
  static void addKeys(const Shape& shape, const std::string& path, std::vector<KnownKey>& known) {
    for (const Shape& inner : shape.inner)
      addKeys(inner, shape.kind == Kind::kList ? path + "[]" : path, known);
    for (const JsonKey& key : shape.keys) {
      known.push_back({key.name, path.empty() ? "the top level" : path});
      addKeys(key.shape, below(path, key.name), known);
    }
  }

  const std::filesystem::path& file_;
  const std::string& kind_;
  const Shape& whole_;
};

}  // namespace

std::string describe(const JsonShape& shape) {
  if (!shape.meaning.empty()) return shape.meaning;
  switch (shape.kind) {
    case Kind::kText:
      return "a text that is not empty";
    case Kind::kName:
      return "a name without commas, quotes or line breaks";
    case Kind::kFile:
      return "the path of a file";
    case Kind::kImage:
      return "the path of an image";
    case Kind::kWord:
      return quotedList(shape.words);
    case Kind::kNumber:
      if (shape.max < kLength) return "a number from " + plain(shape.min) + " to " + plain(shape.max);
      return shape.above_min  ? "a number above " + plain(shape.min)
             : shape.min == 0 ? "a number from 0 up"
                              : "a number";
    case Kind::kInteger:
      return "a whole number from " + plain(shape.min) + " to " + plain(shape.max);
    case Kind::kList: {
      std::string count = shape.min == shape.max ? plain(shape.min) + " values"
                          : shape.max < kMany    ? plain(shape.min) + " to " + plain(shape.max) + " values"
                          : shape.min == 1       ? "one or more values"
                          : shape.min > 1        ? plain(shape.min) + " or more values"
                                                 : "values";
      return "a list of " + count + ", each " + describe(shape.inner[0]);
    }
    case Kind::kObject:
      if (!shape.forms.empty()) return "an object with " + quotedList(shape.forms);
      if (shape.keys.empty()) return "an empty object";
      for (const JsonKey& key : shape.keys)
        if (key.required) return "an object with " + inQuotes(key.name);
      return "an object";
    case Kind::kMap:
      return "an object whose values are each " + describe(shape.inner[0]);
    case Kind::kEither: {
      std::vector<std::string> parts;
      for (const Shape& s : shape.inner) parts.push_back(describe(s));
      return joined(parts, ", or ");
    }
  }
  return {};
}

std::filesystem::path pathIn(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path named(std::u8string(text.begin(), text.end()));
  return (std::filesystem::absolute(file).parent_path() / named).lexically_normal();
}

JsonFile readJson(const std::filesystem::path& file, const JsonShape& shape, const char* kind) {
  const std::vector<uint8_t> bytes = readBytes(file);
  return parseJson({bytes.begin(), bytes.end()}, file, shape, kind);
}

JsonFile parseJson(const std::string& text, const std::filesystem::path& file, const JsonShape& shape,
                   const char* kind) {
  const std::string word = kind;
  SyntaxCheck syntax(text, file, word);
  json::sax_parse(text, &syntax, nlohmann::detail::input_format_t::json, true, true);
  JsonFile read{json::parse(text, nullptr, true, true), {}};
  Checker checker(file, word, shape);
  checker.check(read.value);
  read.files = std::move(checker.files);
  return read;
}

}  // namespace furrow::pipeline
