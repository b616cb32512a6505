#include "editor/ui/play_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "editor/ui/actions.h"
#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

bool contains(const std::string& text, const std::string& part) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

// A slider that shows what plays until it is held. True when it changed what is held.
void heldSlider(const std::string& prefix, const std::string& name, std::map<std::string, float>& held,
                float playing, float low, float high, const char* tip) {
  const auto found = held.find(name);
  const bool is_held = found != held.end();
  float value = is_held ? found->second : playing;
  if (!is_held)
    for (const ImGuiCol color : {ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive})
      ImGui::PushStyleColor(color, IM_COL32(130, 132, 138, 255));
  if (slider((prefix + name).c_str(), name.c_str(), value, std::min(low, value), std::max(high, value),
             "%.2f", (name + ": " + tip).c_str()))
    held[name] = value;
  if (!is_held) ImGui::PopStyleColor(2);
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) held.erase(name);
}

}  // namespace

void drawPlayPanel(State& state, const preview::PosedFrame* frame, Share& share) {
  Session& session = state.session;
  if (!session.shown() || !frame) {
    ImGui::TextDisabled(session.cooking() ? "Cooking ..." : "Nothing to play");
    return;
  }
  const AssetView& asset = session.shown()->view();
  Player& player = session.player;
  static std::string search;
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 4.6f * em());
  ImGui::InputTextWithHint("##play.search", "Search sliders", &search);
  if (ImGui::IsItemDeactivated() && ImGui::IsKeyPressed(key::kEscape)) search.clear();
  mark("play.search");
  tooltip("Shows the sliders whose names contain this; capitals do not matter. Escape shows all  (Ctrl+F)");
  if (pressed({'F', true, false})) ImGui::SetKeyboardFocusHere(-1);
  ImGui::SameLine();
  if (button("play.reset", "Reset", "Lets go of every slider: clip and file decide again",
             !player.morphs.empty() || !player.regions.empty(), 4.1f * em())) {
    player.morphs.clear();
    player.regions.clear();
  }
  ImGui::BeginChild("sliders", {0, 0}, false, ImGuiWindowFlags_NavFlattened);
  if (section("section.regions", "Regions",
              "Scripted weight of every layer, added to what the squeeze gives")) {
    for (uint32_t l = 0; l < asset.layerCount(); ++l) {
      const std::string name(asset.layers[l].name);
      if (contains(name, search))
        heldSlider("region.", name, player.regions, frame->region_weights[l], -1.0f, 1.0f,
                   "scripted weight of this layer, -1 stretch to 1 squeeze. Right click: let go");
    }
  }
  if (asset.morphs.empty()) {
    if (section("section.morphs", "Morph targets", "Weights of the character's shapes"))
      ImGui::TextDisabled("The character has none");
  } else if (section("section.morphs", "Morph targets", "Weights of the character's shapes")) {
    std::vector<std::string> seen;
    for (size_t m = 0; m < asset.morphs.size(); ++m) {
      const std::string name = morphKey(asset.morphs[m].name, m);
      if (!contains(name, search) || std::find(seen.begin(), seen.end(), name) != seen.end()) continue;
      seen.push_back(name);
      heldSlider("morph.", name, player.morphs, frame->morph_weights[m], 0.0f, 1.0f,
                 "weight of this morph target, 0 to 1. Right click: let go");
    }
    if (seen.empty()) ImGui::TextDisabled("none contains \"%s\"", search.c_str());
  }
  if (section("section.breathing", "Breathing test", "The whole character grows and shrinks, as a bulge does",
              false)) {
    Breathing& breathing = player.breathing;
    if (checkbox("breathing.on", "On", breathing.on, "Plays with the timeline") && breathing.on)
      player.playing = true;
    slider("breathing.amplitude", "Amplitude", breathing.amplitude, 0.01f, 0.5f, "%.2f",
           "How far lengths change, of their length at rest, 0.01 to 0.5");
    slider("breathing.period", "Period", breathing.period, 0.2f, 20.0f, "%.2f s",
           "Of a breath, 0.2 to 20 seconds", ImGuiSliderFlags_Logarithmic);
    row("Axes");
    constexpr const char* kAxes[] = {"X", "Y", "Z"};
    for (int axis = 0; axis < 3; ++axis) {
      if (axis > 0) ImGui::SameLine();
      if (toggle((std::string("breathing.") + kAxes[axis]).c_str(), kAxes[axis], breathing.axes[axis],
                 "Whether lengths change along this axis of the scene"))
        breathing.axes[axis] = !breathing.axes[axis];
    }
  }
  if (section("section.pictures", "Pictures",
              "Sizes and numbers of pictures, turntables and clips of the File menu", share.running()))
    share.draw();
  ImGui::EndChild();
}

void drawTimeline(State& state) {
  Session& session = state.session;
  Player& player = session.player;
  const bool some = session.shown() != nullptr;
  const pipeline::Rig none;
  const pipeline::Rig& rig = some ? session.shown()->loaded->rig : none;
  const double length = player.duration(rig);

  std::vector<std::string> names = {"(no clip)"};
  for (size_t c = 0; c < rig.clips.size(); ++c) names.push_back(clipKey(rig, c));
  std::string clip = player.clip.empty() ? names.front() : player.clip;
  ImGui::SetNextItemWidth(11.0f * em());
  if (ImGui::BeginCombo("##timeline.clip", clip.c_str())) {
    for (const std::string& name : names) {
      if (ImGui::Selectable(name.c_str(), name == clip)) {
        player.clip = name == names.front() ? std::string() : name;
        player.time = 0.0;
      }
      mark(("timeline.clip." + name).c_str());
    }
    ImGui::EndCombo();
  } else {
    mark("timeline.clip");
    tooltip("The clip that moves the character");
  }
  ImGui::SameLine();
  if (button(
          "timeline.take", player.take ? player.take_name.c_str() : "Take ...",
          "Plays face shapes from a CSV file of Live Link Face, with the clip or alone; again: takes it away",
          some)) {
    if (player.take)
      player.take.reset();
    else
      state.dialog = Dialog::kTake;
  }
  ImGui::SameLine(0.0f, 1.5f * em());
  const bool plays = length > 0.0;
  if (button("timeline.start", "|<", "To the start  (Home)", plays)) player.time = 0.0;
  ImGui::SameLine();
  if (toggle("timeline.play", player.playing ? "Pause" : " Play ", player.playing, "Plays or pauses  (Space)",
             plays))
    player.playOrPause(rig);
  ImGui::SameLine();
  if (toggle("timeline.loop", "Loop", player.loop, "Begins again at the end", some))
    player.loop = !player.loop;
  ImGui::SameLine();
  ImGui::SetNextItemWidth(6.5f * em());
  bareSlider("timeline.speed", player.speed, 0.1f, 4.0f, "x %.2f",
             "Speed, 0.1 to 4 times that of the clip; Ctrl+click to type", ImGuiSliderFlags_Logarithmic);
  ImGui::SameLine(0.0f, 1.5f * em());
  float time = static_cast<float>(player.time);
  char format[48];
  std::snprintf(format, sizeof format, "%%.2f / %.2f s", length);
  ImGui::SetNextItemWidth(std::max(ImGui::GetContentRegionAvail().x, 8.0f * em()));
  ImGui::BeginDisabled(!plays);
  if (bareSlider(
          "timeline.time", time, 0.0f, plays ? static_cast<float>(length) : 1.0f, format,
          "Time in seconds, from 0 to the end of the clip; drag to scrub, comma and period step a frame "
          "of 1/30 s"))
    player.time = double{time};
  ImGui::EndDisabled();
}

}  // namespace furrow::editor::ui
