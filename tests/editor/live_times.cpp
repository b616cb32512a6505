// Prints how long the editor takes: from a change on disk to the first picture of the new surface, and to the
// end of the whole cook, which begins behind that picture; and for a step of the brush. In parentheses, what
// all threads spent. Nothing
// here fails: the figures are of the machine.
//
//   live_times FOLDER [SIZE]     FOLDER: what furrow_content writes; SIZE of the picture, default 900

#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <thread>
#include <utility>

#include "editor/preview/headless_context.h"
#include "editor/preview/renderer.h"
#include "editor/session/paint.h"
#include "editor/session/session.h"
#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::test {
namespace {

using namespace furrow::editor;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kIdle = std::chrono::milliseconds(100),
               kFrame = std::chrono::milliseconds(16);  // the window's

// Of all threads, milliseconds.
double processor() {
  return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

std::string text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// As the window's loop does until something else than `before` is shown; milliseconds.
double untilShown(Session& session, const std::shared_ptr<Shown>& before) {
  const Clock::time_point begin = Clock::now();
  Clock::time_point last = begin;
  do {
    std::this_thread::sleep_for(session.cooking() ? kFrame : kIdle);
    const Clock::time_point now = Clock::now();
    session.update(std::chrono::duration<double>(now - last).count());
    last = now;
  } while (session.shown() == before);
  return since(begin);
}

// As the window draws: with one renderer, which goes from asset to asset.
class Picture {
 public:
  explicit Picture(uint32_t size) { options_.width = options_.height = size; }

  void draw(const std::shared_ptr<Shown>& shown, const Player& player) {
    const std::shared_ptr<Shown> before = std::exchange(shown_, shown);
    if (!renderer_) {
      renderer_ = std::make_unique<preview::Renderer>(shown->view());
      options_.camera = preview::fitCamera(shown->view().positions, 1.0f, 0.0f, 0.0f);
    } else {
      renderer_->show(shown->view());
    }
    options_.tier = preview::Tier::kCpu;
    renderer_->render(player.frame(*shown->loaded).input, options_);
  }

 private:
  preview::RenderOptions options_;
  std::shared_ptr<Shown> shown_;
  std::unique_ptr<preview::Renderer> renderer_;
};

void measure(const fs::path& content, const std::string& name, uint32_t size) {
  const ScratchFolder folder;
  for (const char* kind : {".glb", ".json"})
    fs::copy_file(content / (name + kind), folder.path() / (name + kind));
  const fs::path source = folder.path() / (name + ".glb"), recipe = folder.path() / (name + ".json");
  Session session;
  Picture picture(size);
  session.open(source);
  untilShown(session, nullptr);
  picture.draw(session.shown(), session.player);
  const auto settle = [&] {
    while (session.cooking()) {
      std::this_thread::sleep_for(kFrame);
      session.update(0.016);
    }
    session.update(1.0);
    picture.draw(session.shown(), session.player);
  };
  settle();
  std::printf("%s: %u triangles, %u layers\n", name.c_str(), session.shown()->view().triangleCount(),
              session.shown()->view().layerCount());
  const auto change = [&](const char* what, const fs::path& file, const std::string& bytes) {
    const std::shared_ptr<Shown> before = session.shown();
    pipeline::writeFile(file, std::as_bytes(std::span(bytes)));
    const double spent = processor();
    const Clock::time_point begin = Clock::now();
    const double draft = untilShown(session, before), draft_spent = processor() - spent;
    const std::shared_ptr<Shown> first = session.shown();
    picture.draw(first, session.player);
    const double seen = since(begin), seen_spent = processor() - spent;
    if (session.cooking()) untilShown(session, first);
    std::printf(
        "  %-20s first picture %.0f ms (%.0f of processors), of that draft %.0f (%.0f); whole cook %.0f "
        "(%.0f)\n",
        what, seen, seen_spent, draft, draft_spent, since(begin), processor() - spent);
    settle();
  };
  std::string edited = text(recipe);
  const size_t seed = edited.find("\"seed\": ");
  edited.insert(seed + 8, 1, '1');
  change("a layer changed", recipe, edited);
  // Everything hangs on the weld.
  edited.insert(edited.find("\"layers\""), "\"weld\": { \"tolerance\": 0 },\n  ");
  change("weld changed", recipe, edited);
  change("mesh written again", source, text(source));

  const AssetView& asset = session.shown()->view();
  const preview::PosedFrame frame = session.player.frame(*session.shown()->loaded);
  constexpr int kRounds = 20;
  const auto each = [&](const char* what, const auto& work) {
    double least = 1e9;
    for (int i = 0; i < kRounds; ++i) {
      const Clock::time_point begin = Clock::now();
      work(i);
      least = std::min(least, since(begin));
    }
    std::printf("  %-20s %6.2f ms\n", what, least);
  };
  PosedSurface& surface = session.shown()->surface;
  each("pose on the CPU", [&](int) { surface.pose(frame.input); });
  const glm::vec3 middle = surface.at(0, {1, 0, 0});
  each("pick",
       [&](int i) { surface.hit(middle + glm::vec3(0, 0, 10), glm::vec3(0.001f * float(i), 0, -1)); });
  const auto canvas = std::make_shared<Canvas>(asset, session.document.recipe().layers[0], 1024);
  const auto before =
      std::make_shared<pipeline::ByteImage>(canvas->current(Painted::kBias, asset, asset.layerCount()));
  Stroke stroke(canvas, before, Painted::kBias, Brush{}, diagonalOf(asset));
  each("step of a stroke", [&](int i) {
    stroke.moveTo(surface.restAt(static_cast<uint32_t>(10 * i), {1, 0, 0}),
                  surface.restNormal(static_cast<uint32_t>(10 * i)));
    vertexBias(stroke.image(), *canvas, asset);
  });
}

}  // namespace
}  // namespace furrow::test

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: live_times FOLDER [SIZE]\n");
    return 2;
  }
  const furrow::preview::HeadlessContext context;
  for (const char* name : {"panel", "jacket", "face"})
    furrow::test::measure(argv[1], name, argc > 2 ? static_cast<uint32_t>(std::stoul(argv[2])) : 900);
} catch (const std::exception& error) {
  std::fprintf(stderr, "live_times: %s\n", error.what());
  return 1;
}
