#include "editor/ui/character_section.h"

#include <algorithm>

#include "editor/ui/widgets.h"
#include "pipeline/scene/rest.h"

namespace furrow::editor::ui {
namespace {

using pipeline::Recipe;
using pipeline::Rest;

// The weights that are not 0 in the pose that is seen.
pipeline::RestMorphs shownMorphs(const AssetView& asset, const preview::PosedFrame& frame) {
  pipeline::RestMorphs morphs;
  for (size_t m = 0; m < asset.morphs.size(); ++m)
    if (frame.morph_weights[m] != 0.0f && !asset.morphs[m].name.empty())
      morphs.weights[std::string(asset.morphs[m].name)] = double{frame.morph_weights[m]};
  return morphs;
}

void setRest(State& state, const Rest& rest) {
  state.editAll("Rest pose", [&](Recipe& recipe) { recipe.rest = rest; });
}

void drawRest(State& state, const preview::PosedFrame* frame) {
  const Session& session = state.session;
  const Rest& rest = session.document.recipe().rest;
  const Player& player = session.player;
  const auto* clip = std::get_if<pipeline::RestClip>(&rest);
  const auto* morphs = std::get_if<pipeline::RestMorphs>(&rest);
  const auto* file = std::get_if<pipeline::RestFile>(&rest);
  enum Kind { kBind, kClip, kMorphs, kFile };
  constexpr const char* kNames[] = {"Bind pose", "Clip, as shown", "Morph targets, as shown", "File ..."};
  int index = static_cast<int>(rest.index());
  if (choice(
          "rest", "Rest pose", index, kNames,
          "The pose in which the surface is relaxed, from which squeezes are measured: the file's own, the "
          "clip at the time that you see, the weights of the morph targets that you see, or a file with "
          "the same vertices in the same order")) {
    const std::string before = session.shown() && !session.shown()->loaded->rig.clips.empty()
                                   ? clipKey(session.shown()->loaded->rig, 0)
                                   : std::string();
    if (index == kBind) setRest(state, pipeline::RestBind{});
    if (index == kClip && before.empty())
      state.session.tell(Message::Kind::kError,
                         session.source().string() + ": it has no clips: choose another rest pose");
    else if (index == kClip)
      setRest(state, pipeline::RestClip{player.clip.empty() ? before : player.clip, player.time});
    if (index == kMorphs && frame) setRest(state, shownMorphs(session.shown()->view(), *frame));
    if (index == kFile) {
      state.file_chosen = [&state](const std::filesystem::path& chosen) {
        setRest(state, pipeline::RestFile{chosen});
      };
      state.dialog = Dialog::kRestFile;
    }
    return;
  }
  if (clip) {
    float time = static_cast<float>(clip->time);
    row("  Clip");
    ImGui::TextUnformatted(clip->clip.c_str());
    double length = 0.0;
    if (session.shown())
      if (const pipeline::Clip* found = pipeline::findClip(session.shown()->loaded->rig, clip->clip))
        length = found->duration;
    if (slider("rest.time", "  Time", time, 0.0f, std::max(static_cast<float>(length), time), "%.2f s",
               "Seconds into the clip, from 0 to its end"))
      setRest(state, pipeline::RestClip{clip->clip, double{time}});
  } else if (morphs) {
    for (const auto& [name, weight] : morphs->weights) {
      float value = static_cast<float>(weight);
      const bool changed = slider(("rest." + name).c_str(), ("  " + name).c_str(), value, 0.0f, 1.0f, "%.2f",
                                  "Weight of this morph target at rest, 0 to 1. Right click: leave it out");
      const bool removed = ImGui::IsItemClicked(ImGuiMouseButton_Right);
      if (!changed && !removed) continue;
      pipeline::RestMorphs next = *morphs;
      if (removed)
        next.weights.erase(name);
      else
        next.weights[name] = double{value};
      return setRest(state, next);
    }
    if (morphs->weights.empty()) ImGui::TextDisabled("every morph target at 0");
  } else if (file) {
    row("  File");
    ImGui::TextUnformatted(file->file.filename().string().c_str());
  }
}

// A side in texels, from a list that has `now` in it; `zero` stands for 0.
bool texels(const char* id, const char* label, uint32_t& now, uint32_t least, const char* zero,
            const char* tip) {
  std::vector<uint32_t> sizes = {0};
  for (uint32_t size = least; size <= 8192; size *= 2) sizes.push_back(size);
  if (std::find(sizes.begin(), sizes.end(), now) == sizes.end()) sizes.push_back(now);
  std::sort(sizes.begin(), sizes.end());
  std::vector<std::string> names;
  for (const uint32_t size : sizes) names.push_back(size == 0 ? zero : std::to_string(size));
  std::string name = now == 0 ? zero : std::to_string(now);
  if (!choice(id, label, name, names, tip)) return false;
  now = sizes[static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
  return true;
}

}  // namespace

void drawCharacterSection(State& state, const preview::PosedFrame* frame, float unit) {
  if (!section("section.character", "All layers",
               "What holds for every layer: the rest pose, the weld, the sizes of maps and what is hidden",
               false))
    return;
  drawRest(state, frame);
  const Recipe& recipe = state.session.document.recipe();
  float tolerance = static_cast<float>(recipe.weld_tolerance.value_or(0.0));
  if (slider("weld", "Weld within", tolerance, 0.0f, 0.001f * unit,
             recipe.weld_tolerance ? "%.3g" : "automatic",
             "Vertices at most so far apart are one place, in the file's unit of length, up to 0.1% of the "
             "character's size; 0: equal positions alone. Raise it where the view of points shows a seam. "
             "Right click: automatic, as wide as rounding"))
    state.editAll("Weld", [&](Recipe& edited) { edited.weld_tolerance = double{tolerance}; });
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right))
    state.editAll("Weld", [](Recipe& edited) { edited.weld_tolerance.reset(); });
  uint32_t size = recipe.map_size;
  if (texels("map_size", "Map size", size, 128, "Automatic",
             "Largest side of a wrinkle map, in texels, 128 to 8192; automatic: as fine as the wrinkles, at "
             "most 2048"))
    state.editAll("Map size", [&](Recipe& edited) { edited.map_size = size; });
  size = recipe.preview_size;
  if (texels("preview_size", "Model's maps", size, 256, "Left out",
             "Largest side, in texels, of the model's own colour and normal maps, which the asset keeps for "
             "previews, up to 8192; a game has its own"))
    state.editAll("Model's maps", [&](Recipe& edited) { edited.preview_size = size; });
  std::vector<std::string> names = recipe.hidden, hidden = recipe.hidden;
  if (state.session.shown())
    for (const Part& part : state.session.shown()->view().parts) {
      addName(names, part.mesh);
      addName(names, part.material);
    }
  if (!names.empty() && choices("hidden", "Hidden", hidden, names,
                                "Meshes and materials that previews do not draw, such as a shell around the "
                                "eyes that a game makes see-through; they are cooked all the same",
                                "None"))
    state.editAll("Hidden", [&](Recipe& edited) { edited.hidden = hidden; });
}

}  // namespace furrow::editor::ui
