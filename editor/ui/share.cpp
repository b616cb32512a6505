#include "editor/ui/share.h"

#include <cmath>
#include <cstdio>

#include "editor/ui/widgets.h"
#include "pipeline/error.h"
#include "pipeline/maps/image.h"

namespace furrow::editor::ui {
namespace {

constexpr double kRounding = 1e-4;  // of a frame: a clip's length is stored as a float

}  // namespace

void Share::saveImage(State& state, Viewport& viewport, const preview::PosedFrame& frame,
                      const std::filesystem::path& file) {
  try {
    pipeline::writeImage(file, viewport.picture(state, frame, static_cast<uint32_t>(options.width),
                                                static_cast<uint32_t>(options.height)));
    state.session.tell(Message::Kind::kNote, file.string() + ": written");
  } catch (const pipeline::Error& error) {
    state.session.tell(Message::Kind::kError, error.what());
  }
}

void Share::startTurntable(const std::filesystem::path& folder) {
  folder_ = folder;
  turns_ = true;
  next_ = 0;
  count_ = options.frames;
}

void Share::startClip(State& state, const std::filesystem::path& folder) {
  const double seconds = state.session.player.duration(state.session.shown()->loaded->rig);
  folder_ = folder;
  turns_ = false;
  next_ = 0;
  count_ = static_cast<int>(std::floor(seconds * options.fps + kRounding)) + 1;
}

void Share::step(State& state, Viewport& viewport) {
  if (!running() || !state.session.shown()) return cancel();
  const preview::Camera camera = state.camera;
  Player& player = state.session.player;
  const double time = player.time;
  char name[32];
  std::snprintf(name, sizeof name, "frame_%04d.png", next_);
  if (turns_)
    state.camera.yaw += 360.0f * static_cast<float>(next_) / static_cast<float>(count_);
  else
    player.time = static_cast<double>(next_) / options.fps;
  try {
    std::filesystem::create_directories(folder_);
    const preview::PosedFrame frame = player.frame(*state.session.shown()->loaded);
    pipeline::writeImage(folder_ / name, viewport.picture(state, frame, static_cast<uint32_t>(options.width),
                                                          static_cast<uint32_t>(options.height)));
    if (++next_ == count_)
      state.session.tell(Message::Kind::kNote,
                         folder_.string() + ": " + std::to_string(count_) + " frames written");
  } catch (const std::exception& error) {
    state.session.tell(Message::Kind::kError, error.what());
    cancel();
  }
  state.camera = camera;
  player.time = time;
}

void Share::draw() {
  integer("share.width", "Width", options.width, 16, 4096, "Of the pictures in pixels, 16 to 4096");
  integer("share.height", "Height", options.height, 16, 4096, "Of the pictures in pixels, 16 to 4096");
  integer("share.frames", "Turntable frames", options.frames, 2, 2000, "Pictures in a whole turn, 2 to 2000");
  integer("share.fps", "Clip, a second", options.fps, 1, 120, "Pictures a second of the clip, 1 to 120");
  if (!running()) return;
  char text[48];
  std::snprintf(text, sizeof text, "%d of %d", next_, count_);
  ImGui::ProgressBar(static_cast<float>(next_) / static_cast<float>(count_), {-1.0f, 0.0f}, text);
  if (button("share.cancel", "Stop", "Stops after this frame; those that are written stay")) cancel();
}

}  // namespace furrow::editor::ui
