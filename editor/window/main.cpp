// furrow-editor: see, play, paint and tune wrinkles in a window.

#include <epoxy/gl.h>
// epoxy/gl.h first: GLFW would bring the system's.
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <functional>

#include "editor/preview/headless_context.h"
#include "editor/ui/headless_screen.h"
#include "editor/ui/input_queue.h"
#include "editor/ui/widgets.h"
#include "pipeline/error.h"
#include "pipeline/input_file.h"

namespace furrow::editor {
namespace {

using pipeline::Error;
using pipeline::Exit;

static_assert(ui::key::kEscape == GLFW_KEY_ESCAPE && ui::key::kPageDown == GLFW_KEY_PAGE_DOWN &&
              ui::key::kF1 == GLFW_KEY_F1 && ui::key::kSpace == GLFW_KEY_SPACE);

constexpr double kIdle = 0.1;          // seconds between frames where nothing happens
constexpr double kFrame = 1.0 / 60.0;  // the least between others, also where the screen sets no pace

struct Options {
  std::string file, recipe, script, frames = ".", size, tier;
  float scale = 0.0f;
  bool window = false;
};

std::string readText(const std::string& file) {
  const std::vector<uint8_t> bytes = pipeline::readBytes(file);
  return {bytes.begin(), bytes.end()};
}

void parseSize(const std::string& text, int& width, int& height) {
  const char* end = text.data() + text.size();
  const auto [x, first] = std::from_chars(text.data(), end, width);
  if (first == std::errc() && x != end && *x == 'x') {
    const auto [stop, second] = std::from_chars(x + 1, end, height);
    if (second == std::errc() && stop == end && width >= Settings::kLeastWidth &&
        height >= Settings::kLeastHeight && width <= 8192 && height <= 8192)
      return;
  }
  throw Error(Exit::kBadUsage, "--size " + text, "is not WIDTHxHEIGHT from 640x480 to 8192x8192",
              "write for example --size 1440x900");
}

// The connection to the screen.
class Display {
 public:
  Display() {
    glfwSetErrorCallback([](int, const char* text) { last_error_ = text; });
    if (!glfwInit())
      throw Error(Exit::kEnvironment, "display", "no window can be opened (" + last_error_ + ")",
                  "start it where there is a screen, or use 'furrow render'");
  }
  ~Display() { glfwTerminate(); }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  static const std::string& lastError() { return last_error_; }

 private:
  inline static std::string last_error_ = "no reason given";
};

// A window with OpenGL and imgui.
class Window {
 public:
  Window(int width, int height) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    window_ = glfwCreateWindow(width, height, "furrow", nullptr, nullptr);
    if (!window_) {  // a driver that cannot tell of a reset
      glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_NO_ROBUSTNESS);
      window_ = glfwCreateWindow(width, height, "furrow", nullptr, nullptr);
    }
    if (!window_)
      throw Error(Exit::kEnvironment, "display",
                  "no window with OpenGL 3.3 can be opened (" + Display::lastError() + ")",
                  "update the graphics driver");
    const auto least = [this](int pixels) { return static_cast<int>(scale() * static_cast<float>(pixels)); };
    glfwSetWindowSizeLimits(window_, least(Settings::kLeastWidth), least(Settings::kLeastHeight),
                            GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    ImGui::CreateContext();
    ImGui_ImplGlfw_InitForOpenGL(window_, false);
    listen();
    ui::setUpImgui();
    ImGui_ImplOpenGL3_Init("#version 330 core");
  }
  ~Window() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  GLFWwindow* handle() const { return window_; }

  // Pixels of the usual size that the screen wants for one, where the window's own units do not say it.
  float scale() const {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window_, &x, &y);
    int width = 1, pixels = 1, ignored = 0;
    glfwGetWindowSize(window_, &width, &ignored);
    glfwGetFramebufferSize(window_, &pixels, &ignored);
    return width > 0 && pixels > 0 ? x * static_cast<float>(width) / static_cast<float>(pixels) : x;
  }

  void begin() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    input_.apply(ImGui::GetIO());
  }
  bool pending() const { return !input_.empty(); }  // events for another frame

  std::function<void(const char* file)> dropped;

  void end() {
    ImGui::Render();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    glViewport(0, 0, width, height);
    glClearColor(0.08f, 0.08f, 0.085f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }

  // Of what end() has drawn, before it is shown.
  pipeline::Image picture() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    const auto w = static_cast<uint32_t>(width), h = static_cast<uint32_t>(height);
    std::vector<uint8_t> bytes(size_t{4} * w * h);
    glReadBuffer(GL_BACK);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
    pipeline::ByteImage image{w, h, 4, {}};
    for (uint32_t y = h; y-- > 0;)
      image.pixels.insert(image.pixels.end(), &bytes[size_t{4} * w * y],
                          &bytes[size_t{4} * w * y] + size_t{4} * w);
    for (size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 255;
    return pipeline::toFloats(image);
  }

 private:
  static Window& of(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

  // A letter is the one that the keyboard's layout has there.
  static int keyOf(int key, int scancode) {
    const char* name = glfwGetKeyName(key, scancode);
    if (!name || !std::isalpha(static_cast<unsigned char>(name[0])) || name[1] != 0) return key;
    return std::toupper(static_cast<unsigned char>(name[0]));
  }

  void listen() {
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int scancode, int action, int) {
      if (action != GLFW_REPEAT) of(window).input_.key(keyOf(key, scancode), action == GLFW_PRESS);
    });
    glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned c) { of(window).input_.text(c); });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
      of(window).input_.button(button, action == GLFW_PRESS);
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
      of(window).input_.pointer({static_cast<float>(x), static_cast<float>(y)});
    });
    glfwSetCursorEnterCallback(window_, [](GLFWwindow* window, int entered) {
      if (!entered) of(window).input_.pointerLeft();
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* window, double x, double y) {
      of(window).input_.wheel(static_cast<float>(x), static_cast<float>(y));
    });
    glfwSetWindowFocusCallback(window_, [](GLFWwindow* window, int focused) {
      if (!focused) of(window).input_.release();
    });
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** files) {
      if (count > 0) of(window).dropped(files[0]);
    });
  }

  GLFWwindow* window_ = nullptr;
  ui::InputQueue input_;
};

void start(ui::Editor& editor, Session& session, const Options& options) {
  if (!options.tier.empty())
    for (ui::Look& look : editor.state().looks) look.tier = options.tier;
  if (options.file.empty()) return;
  if (options.recipe.empty())
    editor.open(options.file);
  else
    session.open(options.file, options.recipe);
}

void runHeadless(const Options& options, Settings& settings) {
  int width = 1440, height = 900;
  if (!options.size.empty()) parseSize(options.size, width, height);
  const std::string text = readText(options.script);
  std::optional<preview::HeadlessContext> context(std::in_place);
  std::optional<ui::HeadlessScreen> headless;
  const float scale = options.scale > 0.0f ? options.scale : 1.0f;
  headless.emplace(width, height, scale);
  Session session;
  ui::Editor editor(session, settings);
  start(editor, session, options);
  ui::Screen screen = headless->screen();  // of what is in `headless`, the next one too
  screen.remake = [&](const preview::ContextLost& lost) {
    editor.contextLost(lost);
    headless.reset();
    context.reset();
    context.emplace();
    headless.emplace(width, height, scale);
  };
  ui::runScript(text, options.script, editor, screen, options.frames);
}

// The editor in a window, which is made anew when the driver takes its context away.
class Desktop {
 public:
  Desktop(const Options& options, Settings& settings)
      : settings_(settings),
        window_(std::in_place, settings.width, settings.height),
        editor(session, settings) {
    if (options.scale > 0.0f) editor.state().scale = options.scale;
    appear();
  }

  Window& window() { return *window_; }

  void rescale() {
    editor.state().screen_scale = window_->scale();
    const float wanted = editor.state().scale > 0.0f ? editor.state().scale : window_->scale();
    if (wanted == scale_) return;
    scale_ = wanted;
    ui::applyTheme(scale_);
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
  }

  void remake(const preview::ContextLost& lost) {
    editor.contextLost(lost);
    window_.reset();
    window_.emplace(settings_.width, settings_.height);
    appear();
  }

 private:
  void appear() {
    scale_ = 0.0f;
    rescale();
    window_->dropped = [this](const char* file) { editor.drop(file); };
  }

  Settings& settings_;
  const Display display_;  // stays: a server without clients may shut its door
  std::optional<Window> window_;
  float scale_ = 0.0f;

 public:
  Session session;
  ui::Editor editor;  // after the window: it holds what is of the window's context
};

void runWindow(const Options& options, Settings& settings) {
  if (!options.size.empty()) parseSize(options.size, settings.width, settings.height);
  Desktop desktop(options, settings);
  Session& session = desktop.session;
  ui::Editor& editor = desktop.editor;
  start(editor, session, options);

  if (!options.script.empty()) {
    ui::Screen screen;
    screen.begin = [&] {
      // The script's pointer, keys and clock, not those of the window.
      ImGuiIO& io = ImGui::GetIO();
      const ImVec2 pointer = io.MousePos;
      const bool buttons[3] = {io.MouseDown[0], io.MouseDown[1], io.MouseDown[2]};
      const bool ctrl = io.KeyCtrl, shift = io.KeyShift, alt = io.KeyAlt;
      const float step = io.DeltaTime;
      glfwPollEvents();
      desktop.window().begin();
      io.MousePos = pointer;
      std::copy(buttons, buttons + 3, io.MouseDown);
      io.KeyCtrl = ctrl;
      io.KeyShift = shift;
      io.KeyAlt = alt;
      io.DeltaTime = step;
      ImGui::NewFrame();
    };
    pipeline::Image last;
    screen.end = [&] {
      desktop.window().end();
      last = desktop.window().picture();
      glfwSwapBuffers(desktop.window().handle());
    };
    screen.picture = [&] { return last; };
    screen.remake = [&](const preview::ContextLost& lost) { desktop.remake(lost); };
    ui::runScript(readText(options.script), options.script, editor, screen, options.frames);
    return;
  }

  double before = glfwGetTime();
  std::string title;
  while (!editor.quit()) {
    const double rest = editor.busy() ? before + kFrame - glfwGetTime() : kIdle;
    if (rest > 0.0 && !desktop.window().pending())
      glfwWaitEventsTimeout(rest);
    else
      glfwPollEvents();
    GLFWwindow* handle = desktop.window().handle();
    if (glfwWindowShouldClose(handle)) {
      glfwSetWindowShouldClose(handle, GLFW_FALSE);
      editor.askToQuit();
    }
    desktop.rescale();
    const double now = glfwGetTime();
    desktop.window().begin();
    ImGui::NewFrame();
    try {
      editor.frame(now - before);
    } catch (const preview::ContextLost& lost) {
      desktop.remake(lost);
      before = glfwGetTime();
      title.clear();
      continue;
    }
    desktop.window().end();
    glfwSwapBuffers(handle);
    before = now;
    if (editor.title() != title) {
      title = editor.title();
      glfwSetWindowTitle(handle, title.c_str());
    }
    glfwGetWindowSize(handle, &settings.width, &settings.height);
  }
}

int run(int argc, char** argv) {
  CLI::App app("furrow-editor: see, play, paint and tune wrinkles", "furrow-editor");
  app.set_version_flag("--version", "furrow-editor " FURROW_VERSION);
  app.footer(
      "Exit status: 0 done, 1 bad data (an input missing, too), 2 bad usage (also a script that does not get "
      "through), 3 environment (no screen, no OpenGL 3.3).");
  Options options;
  app.add_option(
      "FILE", options.file,
      "A mesh (glTF, OBJ, PLY, STL, OFF), with the recipe of its name if there is one; a recipe (JSON), with "
      "the mesh of its name; or a cooked .furrow to look at");
  app.add_option("--recipe", options.recipe,
                 "Recipe for the mesh, in place of the one of its name; need not exist yet");
  app.add_option("--backend", options.tier, "Tier to compute on (default: as last time)")
      ->check(CLI::IsMember({"auto", "gpu", "gpu-raster", "cpu"}));
  app.add_option("--size", options.size, "WIDTHxHEIGHT of the window (default: as last time)");
  app.add_option("--scale", options.scale,
                 "Scale of text and widgets, 0.5 to 4 (default: what the screen asks for)")
      ->check(CLI::Range(0.5, 4.0));
  CLI::Option* script = app.add_option(
      "--script", options.script, "Play a scripted session without a window, then leave; needs no screen");
  app.add_option("--frames", options.frames, "Folder for the pictures of the script")->needs(script);
  app.add_flag("--window", options.window, "Play the script in a real window")->needs(script);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "furrow-editor: %s: see 'furrow-editor --help'\n", error.what());
    return static_cast<int>(Exit::kBadUsage);
  }
  std::error_code ignored;
  if (!options.file.empty() && !std::filesystem::exists(options.file, ignored))
    throw Error(Exit::kBadData, options.file, "there is no such file", "check the path");
  // A script begins from nothing and leaves nothing behind.
  if (!options.script.empty()) {
    Settings settings;
    options.window ? runWindow(options, settings) : runHeadless(options, settings);
    return static_cast<int>(Exit::kDone);
  }
  const std::filesystem::path file = settingsFile();
  Settings settings = readSettings(file);
  runWindow(options, settings);
  try {
    writeSettings(file, settings);
  } catch (const Error& error) {
    std::fprintf(stderr, "furrow-editor: warning: %s\n", error.what());
  }
  return static_cast<int>(Exit::kDone);
}

}  // namespace
}  // namespace furrow::editor

int main(int argc, char** argv) {
  using furrow::pipeline::Exit;
  try {
    return furrow::editor::run(argc, argv);
  } catch (const furrow::pipeline::Error& error) {
    std::fprintf(stderr, "furrow-editor: %s\n", error.what());
    return static_cast<int>(error.exit());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "furrow-editor: out of memory: close other programs or open a smaller file\n");
    return static_cast<int>(Exit::kEnvironment);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "furrow-editor: unexpected fault (%s): please report it\n", error.what());
    return static_cast<int>(Exit::kBadData);
  }
}
