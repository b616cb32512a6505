#include "pipeline/import/take.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "pipeline/error.h"
#include "pipeline/input_file.h"

namespace furrow::pipeline {
namespace {

constexpr double kRates[] = {24, 25, 30, 48, 50, 60, 100, 120};
constexpr double kUsualRate = 60;
constexpr int64_t kDay = 24 * 60 * 60;

struct Timecode {
  int64_t seconds = 0;
  double frame = 0.0;
  size_t line = 0;  // of the file
};

std::string inQuotes(std::string_view text) {
  std::string out(1, '"');
  out.append(text.substr(0, 40));
  out += '"';
  return out;
}

class Reader {
 public:
  Reader(std::string text, const std::filesystem::path& file) : file_(file), text_(std::move(text)) {
    if (text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff"))
      fail("it is UTF-16", "save it as UTF-8");
    if (text_.starts_with("\xef\xbb\xbf")) next_ = 3;
    if (text_.find('\n') == std::string::npos) std::replace(text_.begin(), text_.end(), '\r', '\n');
    // Spreadsheets leave empty lines, "sep=;", and what their language has for a comma.
    std::string_view head;
    for (size_t end = 0; next_ < text_.size(); next_ = end, ++next_line_) {
      end = std::min(text_.find('\n', next_), text_.size() - 1) + 1;
      head = std::string_view(text_).substr(next_, end - next_);
      if (head.find_first_not_of("\r\n") != head.npos && !head.starts_with("sep=")) break;
    }
    for (const char other : {';', '\t'})
      if (std::ranges::count(head, other) > std::ranges::count(head, separator_)) separator_ = other;
  }

  Take read() {
    Take take;
    std::vector<std::string> row;
    if (!readRow(row)) fail("it is empty", "give a CSV file with a Timecode column");
    const auto named = [&](const char* name) {
      return static_cast<size_t>(std::find(row.begin(), row.end(), name) - row.begin());
    };
    const size_t columns = row.size(), timecode = named("Timecode"), count = named("BlendshapeCount");
    if (timecode == columns) fail("it has no column \"Timecode\"", "export it from Live Link Face as CSV");
    std::vector<size_t> shape_columns;
    for (size_t c = 0; c < columns; ++c) {
      if (c == timecode || c == count) continue;
      shape_columns.push_back(c);
      take.shapes.push_back(row[c]);
    }
    if (take.shapes.empty()) fail("it has no column of a shape", "export it with its blend shapes");
    std::vector<Timecode> codes;
    while (readRow(row)) {
      if (row.size() == 1 && row[0].empty()) continue;
      if (row.size() != columns)
        fail(
            "it has " + std::to_string(row.size()) + " fields, the first line has " + std::to_string(columns),
            "a line may be cut off: remove it");
      codes.push_back(timecodeOf(row[timecode]));
      for (size_t c : shape_columns) take.weights.push_back(static_cast<float>(number(row[c])));
    }
    if (codes.empty()) fail("it has no frames", "record a take");
    setTimes(codes, take);
    return take;
  }

 private:
  [[noreturn]] void fail(const std::string& wrong, const std::string& remedy) const {
    throw Error(Exit::kBadData, file_.string(), "line " + std::to_string(line_) + ": " + wrong, remedy);
  }

  // The fields of the next line; a field in quotes may hold commas, line breaks and doubled quotes.
  bool readRow(std::vector<std::string>& row) {
    row.clear();
    line_ = next_line_;
    if (next_ >= text_.size()) return false;
    row.emplace_back();
    bool quoted = false;
    while (next_ < text_.size()) {
      const char c = text_[next_++];
      if (c == '\n') ++next_line_;
      if (c == '"' && (quoted || row.back().empty())) {
        if (quoted && next_ < text_.size() && text_[next_] == '"')
          row.back() += text_[next_++];
        else
          quoted = !quoted;
      } else if (quoted) {
        row.back() += c;
      } else if (c == '\n') {
        break;
      } else if (c == separator_) {
        row.emplace_back();
      } else if (c != '\r') {
        row.back() += c;
      }
    }
    if (quoted) fail("a quote is not closed", "close it");
    return true;
  }

  // Its decimal point may be a comma.
  double number(std::string_view text) const {
    const size_t begin = text.find_first_not_of(' '), end = text.find_last_not_of(' ');
    std::string trimmed(begin == text.npos ? "" : text.substr(begin, end - begin + 1));
    if (std::ranges::count(trimmed, ',') == 1 && trimmed.find('.') == trimmed.npos)
      std::ranges::replace(trimmed, ',', '.');
    double value = 0.0;
    const auto [stop, error] = std::from_chars(trimmed.data(), trimmed.data() + trimmed.size(), value);
    if (error != std::errc() || stop != trimmed.data() + trimmed.size() || !(std::abs(value) <= 1e6))
      fail(inQuotes(text) + " is not a number", "correct or remove the line");
    return value;
  }

  Timecode timecodeOf(const std::string& text) const {
    double parts[4] = {};
    size_t begin = 0;
    for (int i = 0; i < 4; ++i) {
      size_t end = i < 3 ? text.find(':', begin) : text.size();
      if (end == std::string::npos) fail(inQuotes(text) + " is no timecode", "write HH:MM:SS:FF");
      parts[i] = number(std::string_view(text).substr(begin, end - begin));
      if (parts[i] < 0.0 || parts[i] >= (i == 3 ? kRates[std::size(kRates) - 1] : 60.0) ||
          (i < 3 && parts[i] != std::floor(parts[i])))
        fail(inQuotes(text) + " is no timecode", "write HH:MM:SS:FF");
      begin = end + 1;
    }
    return {static_cast<int64_t>(parts[0] * 3600.0 + parts[1] * 60.0 + parts[2]), parts[3], line_};
  }

  void setTimes(const std::vector<Timecode>& codes, Take& take) {
    double largest = 0.0;
    for (const Timecode& code : codes) largest = std::max(largest, std::floor(code.frame));
    double rate = *std::upper_bound(std::begin(kRates), std::end(kRates) - 1, largest);
    if (codes.front().seconds == codes.back().seconds) rate = std::max(rate, kUsualRate);
    std::vector<float> weights;
    int64_t day = 0;
    const size_t shapes = take.shapes.size();
    for (size_t f = 0; f < codes.size(); ++f) {
      // Timecodes are the time of day: a take may run over midnight.
      if (f > 0 && codes[f - 1].seconds - codes[f].seconds > kDay / 2) day += kDay;
      const double time = static_cast<double>(day + codes[f].seconds - codes[0].seconds) +
                          (codes[f].frame - codes[0].frame) / rate;
      line_ = codes[f].line;
      if (!take.times.empty() && time < take.times.back())
        fail("its timecode lies before that of the frame above", "sort the frames, or split the take");
      if (!take.times.empty() && time == take.times.back()) {
        take.times.pop_back();
        weights.resize(weights.size() - shapes);
      }
      take.times.push_back(time);
      const auto begin = take.weights.begin() + static_cast<std::ptrdiff_t>(f * shapes);
      weights.insert(weights.end(), begin, begin + static_cast<std::ptrdiff_t>(shapes));
    }
    take.weights = std::move(weights);
  }

  const std::filesystem::path& file_;
  std::string text_;
  char separator_ = ',';
  size_t next_ = 0, line_ = 1, next_line_ = 1;
};

}  // namespace

std::vector<float> Take::at(double time) const {
  const size_t after =
      static_cast<size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const size_t a = after == 0 ? 0 : after - 1, b = std::min(after, times.size() - 1);
  const double t = a == b ? 0.0 : (time - times[a]) / (times[b] - times[a]);
  std::vector<float> out(shapes.size());
  for (size_t s = 0; s < out.size(); ++s)
    out[s] = static_cast<float>((1.0 - t) * double{weights[a * out.size() + s]} +
                                t * double{weights[b * out.size() + s]});
  return out;
}

Take readTake(const std::filesystem::path& file) {
  const std::vector<uint8_t> bytes = readBytes(file);
  return parseTake({bytes.begin(), bytes.end()}, file);
}

Take parseTake(std::string text, const std::filesystem::path& file) {
  return Reader(std::move(text), file).read();
}

}  // namespace furrow::pipeline
