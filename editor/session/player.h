#pragma once

// What moves the character: a clip or a take in time, sliders that hold morph targets and regions, and a
// breathing test motion.

#include <map>
#include <optional>
#include <string>

#include "editor/preview/loaded_asset.h"
#include "editor/preview/posed_frame.h"
#include "pipeline/import/take.h"

namespace furrow::editor {

// The whole character grows and shrinks about its middle, so that every direction is stretched and squeezed
// in turn: the length along an axis is 1 + amplitude * sin(2 pi t / period).
struct Breathing {
  bool on = false;
  float amplitude = 0.1f;  // (0, 0.5]
  float period = 2.0f;     // seconds
  bool axes[3] = {true, true, true};
};

// What a clip or morph target is called where it is chosen: its name, or its number where the file gives it
// none; a clip's number, too, where an earlier one has its name.
std::string clipKey(const pipeline::Rig& rig, size_t clip);
std::string morphKey(std::string_view name, size_t number);

class Player {
 public:
  std::string clip;  // its key; empty: none
  std::optional<pipeline::Take> take;
  std::string take_name;
  double time = 0.0;  // seconds
  bool playing = false, loop = true;
  float speed = 1.0f;
  Breathing breathing;
  // By key and name, so that they outlive a new cook; they replace what the clip or the take says.
  std::map<std::string, float> morphs, regions;

  // Seconds of what plays: the clip, the take or a breath; 0 where nothing does.
  double duration(const pipeline::Rig& rig) const;
  // Plays, from the start where it had come to the end, or pauses.
  void playOrPause(const pipeline::Rig& rig);
  // Goes on by `seconds` of the clock; stops at the end unless it loops.
  void advance(const pipeline::Rig& rig, double seconds);

  pipeline::Pose pose(const pipeline::Rig& rig) const;
  preview::PosedFrame frame(const preview::LoadedAsset& loaded) const;
};

}  // namespace furrow::editor
