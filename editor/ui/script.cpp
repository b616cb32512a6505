#include "editor/ui/script.h"

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>

#include "editor/ui/widgets.h"
#include "pipeline/error.h"

namespace furrow::editor::ui {
namespace {

using pipeline::Error;
using pipeline::Exit;

constexpr double kStep = 1.0 / 30.0;
constexpr float kNoTime = 1e-6f;  // imgui takes no less
constexpr int kDragSteps = 6;
constexpr auto kPatience = std::chrono::seconds(300);  // for a cook

class Runner {
 public:
  Runner(Editor& editor, const Screen& screen, const std::filesystem::path& frames, const std::string& name)
      : editor_(editor), screen_(screen), frames_(frames), name_(name) {
    editor_.state().scripted = true;
  }

  void run(const std::string& text) {
    pass();
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      const std::vector<std::string> words = split(line);
      if (!words.empty()) command(words);
    }
  }

 private:
  [[noreturn]] void fail(const std::string& wrong, const std::string& remedy) const {
    throw Error(Exit::kBadUsage, name_, "line " + std::to_string(line_) + ": " + wrong, remedy);
  }

  std::vector<std::string> split(const std::string& line) const {
    std::vector<std::string> words;
    bool quoted = false, in_word = false;
    for (const char c : line) {
      if (!quoted && c == '#' && !in_word) break;
      if (c == '"') {
        quoted = !quoted;
        if (quoted && !in_word) words.emplace_back();
        in_word = true;
      } else if (!quoted && (c == ' ' || c == '\t' || c == '\r')) {
        in_word = false;
      } else {
        if (!in_word) words.emplace_back();
        in_word = true;
        words.back() += c;
      }
    }
    if (quoted) fail("a quote is not closed", "close it");
    return words;
  }

  float number(const std::vector<std::string>& words, size_t at, float otherwise) const {
    if (at >= words.size()) return otherwise;
    try {
      return std::stof(words[at]);
    } catch (const std::exception&) {
      fail("\"" + words[at] + "\" is not a number", "see the list of commands");
    }
  }

  void frame(double seconds = kStep) {
    screen_.begin();
    // NewFrame() has taken the events that were set for it.
    try {
      editor_.frame(seconds);
    } catch (const preview::ContextLost& lost) {
      return screen_.remake(lost);
    }
    screen_.end();
    ImGui::GetIO().MouseWheel = 0.0f;
  }

  void set() {
    ImGuiIO& io = ImGui::GetIO();
    io.DeltaTime = static_cast<float>(kStep);
    io.MousePos = pointer_;
    io.KeyCtrl = ctrl_;
    io.KeyShift = shift_;
    io.KeyAlt = alt_;
  }

  void pass(int frames = 1) {
    for (int i = 0; i < frames; ++i) {
      set();
      frame();
    }
  }

  ImVec2 place(const std::string& id, float x, float y) const {
    const std::optional<Rect> rect = find(id);
    if (!rect) fail("there is no widget \"" + id + "\" on the screen", "see the ids in editor/ui");
    return {rect->low.x + x * (rect->high.x - rect->low.x), rect->low.y + y * (rect->high.y - rect->low.y)};
  }

  void move(ImVec2 to) {
    pointer_ = to;
    pass(2);
  }

  void press(int button, bool down) {
    ImGui::GetIO().MouseDown[button] = down;
    pass(1);
  }

  void click(const std::vector<std::string>& words, int button, int times) {
    if (words.size() < 2) fail("a widget is missing", "write for example: click layer.add");
    move(place(words[1], number(words, 2, 0.5f), number(words, 3, 0.5f)));
    for (int i = 0; i < times; ++i) {
      press(button, true);
      press(button, false);
    }
    pass(2);
  }

  void chord(const std::string& text) {
    Chord chord;
    if (!parseChord(text, chord))
      fail("\"" + text + "\" is not a key", "write for example Ctrl+S, Space or F1");
    const bool ctrl = ctrl_, shift = shift_;
    ctrl_ |= chord.ctrl;
    shift_ |= chord.shift;
    ImGui::GetIO().KeysDown[chord.key] = true;
    pass(1);
    ImGui::GetIO().KeysDown[chord.key] = false;
    ctrl_ = ctrl;
    shift_ = shift;
    pass(2);
  }

  // The script's clock stands still: what is seen afterwards is the same however long it took.
  void wait() {
    const auto begin = std::chrono::steady_clock::now();
    pass(2);
    while (editor_.working()) {
      set();
      ImGui::GetIO().DeltaTime = kNoTime;
      frame(0.0);
      if (editor_.state().session.cooking()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (std::chrono::steady_clock::now() - begin > kPatience)
        fail("the cook does not end", "cook a smaller file");
    }
    pass(3);
  }

  // As on a slow screen: no frame is drawn until the cook's first result is there.
  void stall() const {
    const auto begin = std::chrono::steady_clock::now();
    while (!editor_.state().session.cooked()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (std::chrono::steady_clock::now() - begin > kPatience)
        fail("the cook does not end", "cook a smaller file");
    }
  }

  void expect(const std::vector<std::string>& words) const {
    const Session& session = editor_.state().session;
    const std::string what = words.size() > 1 ? words[1] : "", rest = words.size() > 2 ? words[2] : "";
    bool holds = false;
    if (what == "message") {
      for (const Message& message : session.messages()) holds |= message.text.find(rest) != std::string::npos;
    } else if (what == "no") {
      holds = session.error().empty() &&
              std::none_of(session.messages().begin(), session.messages().end(),
                           [](const Message& m) { return m.kind == Message::Kind::kError; });
    } else if (what == "dirty") {
      holds = session.document.dirty();
    } else if (what == "saved") {
      holds = !session.document.dirty();
    } else if (what == "widget") {
      holds = find(rest).has_value();
    } else if (what == "layers") {
      const std::vector<std::string> wanted(words.begin() + 2, words.end());
      std::vector<std::string> names;
      for (const pipeline::LayerRecipe& layer : session.document.recipe().layers) names.push_back(layer.name);
      holds = names == wanted;
    } else {
      fail("\"expect " + what + "\" is none", "see the list of commands");
    }
    if (holds) return;
    std::string last = session.messages().empty() ? "nothing was told" : session.messages().back().text;
    fail("expected " + what + " " + rest + " (" + last + ")", "look at the last picture");
  }

  void command(const std::vector<std::string>& words) {
    const std::string& what = words[0];
    const auto argument = [&](size_t at) -> const std::string& {
      if (at >= words.size()) fail("\"" + what + "\" needs more words", "see the list of commands");
      return words[at];
    };
    if (what == "open") {
      editor_.open(argument(1));
      pass(1);
      if (words.size() > 2 && words[2] == "stalled") stall();
      pass(1);
    } else if (what == "drop") {
      editor_.drop(argument(1));
      pass(2);
    } else if (what == "wait") {
      wait();
    } else if (what == "frames") {
      pass(static_cast<int>(number(words, 1, 1.0f)));
    } else if (what == "move") {
      move(place(argument(1), number(words, 2, 0.5f), number(words, 3, 0.5f)));
      pass(20);  // until its tooltip shows
    } else if (what == "click") {
      click(words, 0, 1);
    } else if (what == "rightclick") {
      click(words, 1, 1);
    } else if (what == "doubleclick") {
      click(words, 0, 2);
    } else if (what == "drag") {
      argument(5);
      const int button = words.size() > 6 ? (words[6] == "right" ? 1 : words[6] == "middle" ? 2 : 0) : 0;
      const ImVec2 from = place(argument(1), number(words, 2, 0), number(words, 3, 0)),
                   to = place(argument(1), number(words, 4, 0), number(words, 5, 0));
      move(from);
      press(button, true);
      const int steps = std::max(1, static_cast<int>(number(words, 7, kDragSteps)));
      for (int i = 1; i <= steps; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(steps);
        pointer_ = {from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
        pass(1);
      }
      press(button, false);
      pass(2);
    } else if (what == "wheel") {
      move(place(argument(1), 0.5f, 0.5f));
      ImGui::GetIO().MouseWheel = number(words, 2, 1.0f);
      pass(2);
    } else if (what == "key") {
      chord(argument(1));
    } else if (what == "hold") {
      ctrl_ = argument(1) == "Ctrl";
      shift_ = argument(1) == "Shift";
      alt_ = argument(1) == "Alt";
    } else if (what == "release") {
      ctrl_ = shift_ = alt_ = false;
    } else if (what == "type") {
      ImGui::GetIO().AddInputCharactersUTF8(argument(1).c_str());
      pass(2);
    } else if (what == "picture") {
      pass(2);
      std::filesystem::create_directories(frames_);
      pipeline::writeImage(frames_ / (argument(1) + ".png"), screen_.picture());
    } else if (what == "expect") {
      expect(words);
    } else {
      fail("there is no command \"" + what + "\"", "see the list of commands");
    }
  }

  Editor& editor_;
  const Screen& screen_;
  const std::filesystem::path& frames_;
  const std::string& name_;
  int line_ = 0;
  ImVec2 pointer_{-1.0f, -1.0f};
  bool ctrl_ = false, shift_ = false, alt_ = false;
};

}  // namespace

void runScript(const std::string& text, const std::string& name, Editor& editor, const Screen& screen,
               const std::filesystem::path& frames) {
  Runner(editor, screen, frames, name).run(text);
}

}  // namespace furrow::editor::ui
