#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "pipeline/error.h"
#include "pipeline/recipe_schema.h"

namespace furrow::pipeline {

namespace {

using json = nlohmann::json;
using Shape = RecipeShape;
using Kind = RecipeShape::Kind;

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

class Checker {
 public:
  explicit Checker(const std::filesystem::path& recipe) : recipe_(recipe) {}

  void check(const json& value, const Shape& shape, const std::string& path) const {
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

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& remedy) const {
    throw Error(Exit::kBadData, recipe_.string(), path.empty() ? wrong : path + ": " + wrong, remedy);
  }
  [[noreturn]] void failValue(const json& value, const Shape& shape, const std::string& path) const {
    fail(path, path.empty() ? "the recipe is " + shown(value) : "is " + shown(value),
         "give " + describe(shape));
  }

  static std::string below(const std::string& path, const std::string& key) {
    return path.empty() ? key : path + '.' + key;
  }

  void checkFile(const json& value, const Shape& shape, const std::string& path) const {
    const auto& name = value.get_ref<const std::string&>();
    if (name.empty() || name.find('\0') != std::string::npos) failValue(value, shape, path);
    std::filesystem::path found = recipePath(recipe_, name);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(found, ignored))
      fail(path, "no such file " + found.string(), "paths are relative to the recipe");
  }

  // A string that is none of the words is judged by all alternatives, so that the message names them all.
  void checkEither(const json& value, const Shape& shape, const std::string& path) const {
    for (const Shape& s : shape.inner) {
      if (!hasType(value, s)) continue;
      if (s.kind == Kind::kWord && !contains(s.words, value.get_ref<const std::string&>()))
        failValue(value, shape, path);
      return check(value, s, path);
    }
  }

  void checkObject(const json& value, const Shape& shape, const std::string& path) const {
    for (const auto& [name, item] : value.items()) {
      if (std::none_of(shape.keys.begin(), shape.keys.end(),
                       [&, &n = name](const RecipeKey& k) { return k.name == n; }))
        failUnknown(name, shape, path);
    }
    if (!shape.forms.empty()) {
      std::vector<std::string> given;
      for (const std::string& form : shape.forms)
        if (value.contains(form)) given.push_back(form);
      if (given.empty()) fail(path, "says nothing", "give " + describe(shape));
      if (given.size() > 1)
        fail(path, "has both " + inQuotes(given[0]) + " and " + inQuotes(given[1]), "give one of them");
      for (const RecipeKey& key : shape.keys)
        if (!key.form.empty() && key.form != given[0] && value.contains(key.name))
          fail(below(path, key.name), "does not go with " + inQuotes(given[0]),
               "it goes with " + inQuotes(key.form));
    }
    for (const RecipeKey& key : shape.keys) {
      auto found = value.find(key.name);
      if (found != value.end())
        check(*found, key.shape, below(path, key.name));
      else if (key.required)
        fail(below(path, key.name), "is missing", "give " + describe(key.shape));
    }
  }

  [[noreturn]] void failUnknown(const std::string& name, const Shape& shape, const std::string& path) const {
    if (shape.keys.empty()) fail(below(path, name), "no such key", "give an empty object");
    auto nearest =
        std::min_element(shape.keys.begin(), shape.keys.end(), [&](const RecipeKey& a, const RecipeKey& b) {
          return editDistance(name, a.name) < editDistance(name, b.name);
        });
    fail(below(path, name), "no such key", "did you mean " + inQuotes(nearest->name) + "?");
  }

  const std::filesystem::path& recipe_;
};

}  // namespace

std::string describe(const RecipeShape& shape) {
  switch (shape.kind) {
    case Kind::kText:
      return "a text that is not empty";
    case Kind::kName:
      return "a name without commas, quotes or line breaks";
    case Kind::kFile:
      return "the path of a file";
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
      return shape.keys.empty() ? "an empty object" : "an object";
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

std::filesystem::path recipePath(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path named(std::u8string(text.begin(), text.end()));
  return (std::filesystem::absolute(file).parent_path() / named).lexically_normal();
}

void checkRecipe(const json& recipe, const std::filesystem::path& file) {
  Checker(file).check(recipe, recipeShape(), "");
}

}  // namespace furrow::pipeline
