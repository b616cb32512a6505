#include "editor/session/player.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "pipeline/recipe/arkit.h"
#include "pipeline/scene/posing.h"
#include "pipeline/scene/rest.h"

namespace furrow::editor {
namespace {

const pipeline::Clip* clipOf(const pipeline::Rig& rig, const std::string& key) {
  return key.empty() ? nullptr : pipeline::findClip(rig, key);
}

// The middle of the bounding box at rest, root space.
glm::dvec3 middleOf(const AssetView& asset) {
  glm::dvec3 low(1e300), high(-1e300);
  for (const Part& part : asset.parts)
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v) {
      const Float3 p = transformed(part.rest, asset.positions[v]);
      low = glm::min(low, glm::dvec3(p.x, p.y, p.z));
      high = glm::max(high, glm::dvec3(p.x, p.y, p.z));
    }
  return 0.5 * (low + high);
}

}  // namespace

std::string clipKey(const pipeline::Rig& rig, size_t clip) {
  const std::string& name = rig.clips[clip].name;
  return clipOf(rig, name) == &rig.clips[clip] ? name : std::to_string(clip);
}

std::string morphKey(std::string_view name, size_t number) {
  return name.empty() ? std::to_string(number) : std::string(name);
}

double Player::duration(const pipeline::Rig& rig) const {
  double longest = breathing.on ? double{breathing.period} : 0.0;
  if (const pipeline::Clip* playing_clip = clipOf(rig, clip))
    longest = std::max(longest, playing_clip->duration);
  if (take) longest = std::max(longest, take->times.back());
  return longest;
}

void Player::playOrPause(const pipeline::Rig& rig) {
  playing = !playing;
  if (playing && time >= duration(rig)) time = 0.0;
}

void Player::advance(const pipeline::Rig& rig, double seconds) {
  const double length = duration(rig);
  if (!playing || length <= 0.0) return;
  time += seconds * double{speed};
  if (time >= 0.0 && time < length) return;
  if (loop) {
    time = std::fmod(time, length);
    if (time < 0.0) time += length;
  } else {
    time = std::clamp(time, 0.0, length);
    playing = false;
  }
}

pipeline::Pose Player::pose(const pipeline::Rig& rig) const {
  pipeline::Pose pose = pipeline::defaultPose(rig);
  if (const pipeline::Clip* shown = clipOf(rig, clip)) pipeline::applyClip(rig, *shown, time, pose);
  if (take) {
    std::vector<std::string> names;
    for (const pipeline::MorphTarget& target : rig.morphs) names.push_back(target.name);
    const std::vector<float> weights = take->at(time);
    for (size_t s = 0; s < weights.size(); ++s)
      for (size_t m : pipeline::matchShape(names, take->shapes[s]))
        pose.morph_weights[m] = double{weights[s]};
  }
  for (size_t m = 0; m < rig.morphs.size(); ++m)
    if (const auto held = morphs.find(morphKey(rig.morphs[m].name, m)); held != morphs.end())
      pose.morph_weights[m] = double{held->second};
  return pose;
}

preview::PosedFrame Player::frame(const preview::LoadedAsset& loaded) const {
  const AssetView& asset = loaded.asset.view();
  pipeline::PosedRig posed = pipeline::evaluate(loaded.rig, pose(loaded.rig));
  const auto whole = static_cast<float>(pipeline::wholeScale(loaded.rig, posed));
  if (breathing.on) {
    const double grown = 1.0 + double{breathing.amplitude} *
                                   std::sin(2.0 * std::numbers::pi * time / double{breathing.period});
    const glm::dvec3 middle = middleOf(asset);
    glm::dvec3 scale(1.0);
    for (int axis = 0; axis < 3; ++axis)
      if (breathing.axes[axis]) scale[axis] = grown;
    const glm::dmat4 breath =
        glm::translate(glm::scale(glm::translate(glm::dmat4(1.0), middle), scale), -middle);
    for (glm::dmat4& matrix : posed.palette) matrix = breath * matrix;
  }
  std::vector<float> scripted(asset.layerCount(), 0.0f);
  for (uint32_t l = 0; l < asset.layerCount(); ++l)
    if (const auto held = regions.find(std::string(asset.layers[l].name)); held != regions.end())
      scripted[l] = held->second;
  return preview::poseFrame(asset, posed, scripted, whole);
}

}  // namespace furrow::editor
