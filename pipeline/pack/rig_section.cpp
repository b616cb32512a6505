#include "pipeline/pack/rig_section.h"

#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace furrow::pipeline {
namespace {

using nlohmann::json;

template <typename T>
json numbers(const T* data, size_t count) {
  std::vector<uint8_t> bytes(count * sizeof(T));
  if (count > 0) std::memcpy(bytes.data(), data, bytes.size());
  return json::binary(std::move(bytes));
}

template <typename T>
std::vector<T> numbers(const json& value) {
  const auto& bytes = value.get_binary();
  if (bytes.size() % sizeof(T) != 0) throw std::runtime_error("the rig section is not sound");
  std::vector<T> out(bytes.size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}

template <typename Target>
void fill(const json& value, Target& target) {  // a GLM type made of doubles
  const std::vector<double> source = numbers<double>(value);
  if (source.size() * sizeof(double) != sizeof(Target))
    throw std::runtime_error("the rig section is not sound");
  std::memcpy(static_cast<void*>(&target), source.data(), sizeof(Target));
}

template <typename Source>
json doubles(const Source& source) {
  return numbers(reinterpret_cast<const double*>(&source), sizeof(Source) / sizeof(double));
}

void require(bool sound) {
  if (!sound) throw std::runtime_error("the rig section is not sound");
}

}  // namespace

std::vector<std::byte> writeRig(const Rig& rig) {
  json out = {{"nodes", json::array()}, {"morphs", json::array()}, {"clips", json::array()}};
  for (const Node& n : rig.nodes) {
    json node = {{"name", n.name}, {"parent", n.parent}};
    if (n.has_matrix) {
      node["m"] = doubles(n.matrix);
    } else {
      node["t"] = doubles(n.translation);
      node["r"] = doubles(n.rotation);
      node["s"] = doubles(n.scale);
    }
    out["nodes"].push_back(std::move(node));
  }
  for (const MorphTarget& m : rig.morphs)
    out["morphs"].push_back(
        {{"name", m.name}, {"node", m.node}, {"index", m.index}, {"weight", m.default_weight}});
  for (const Clip& c : rig.clips) {
    json channels = json::array();
    for (const Channel& channel : c.channels)
      channels.push_back({{"node", channel.node},
                          {"path", static_cast<int>(channel.path)},
                          {"interpolation", static_cast<int>(channel.interpolation)},
                          {"times", numbers(channel.times.data(), channel.times.size())},
                          {"values", numbers(channel.values.data(), channel.values.size())}});
    out["clips"].push_back({{"name", c.name}, {"duration", c.duration}, {"channels", std::move(channels)}});
  }
  const std::vector<uint8_t> bytes = json::to_cbor(out);
  std::vector<std::byte> section(bytes.size());
  std::memcpy(section.data(), bytes.data(), bytes.size());
  return section;
}

Rig readRig(const AssetView& asset) try {
  const auto* bytes = reinterpret_cast<const uint8_t*>(asset.rig.data());
  const json in = json::from_cbor(bytes, bytes + asset.rig.size());
  Rig rig;
  for (const json& n : in.at("nodes")) {
    Node& node = rig.nodes.emplace_back();
    node.name = n.at("name").get<std::string>();
    node.parent = n.at("parent").get<uint32_t>();
    node.has_matrix = n.contains("m");
    if (node.has_matrix) {
      fill(n.at("m"), node.matrix);
    } else {
      fill(n.at("t"), node.translation);
      fill(n.at("r"), node.rotation);
      fill(n.at("s"), node.scale);
    }
  }
  for (const Node& node : rig.nodes) {
    require(node.parent == kNoIndex || node.parent < rig.nodes.size());
    size_t steps = 0;
    for (uint32_t p = node.parent; p != kNoIndex; p = rig.nodes[p].parent)
      require(p < rig.nodes.size() && ++steps <= rig.nodes.size());
  }
  for (const furrow::PaletteEntry& stored : asset.palette) {
    PaletteEntry& entry = rig.palette.emplace_back();
    entry.node = stored.node_index;
    require(entry.node < rig.nodes.size());
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        entry.inverse_bind[column][row] = double{stored.inverse_bind.m[4 * row + column]};
  }
  std::vector<size_t> targets(rig.nodes.size());
  for (const json& m : in.at("morphs")) {
    rig.morphs.push_back({m.at("name").get<std::string>(), m.at("node").get<uint32_t>(),
                          m.at("index").get<uint32_t>(), m.at("weight").get<double>()});
    require(rig.morphs.back().node < rig.nodes.size());
    ++targets[rig.morphs.back().node];
  }
  for (const json& c : in.at("clips")) {
    Clip& clip = rig.clips.emplace_back();
    clip.name = c.at("name").get<std::string>();
    clip.duration = c.at("duration").get<double>();
    for (const json& ch : c.at("channels")) {
      Channel& channel = clip.channels.emplace_back();
      channel.node = ch.at("node").get<uint32_t>();
      const int path = ch.at("path").get<int>(), interpolation = ch.at("interpolation").get<int>();
      require(channel.node < rig.nodes.size() && path >= 0 && path <= 3 && interpolation >= 0 &&
              interpolation <= 2);
      channel.path = static_cast<ChannelPath>(path);
      channel.interpolation = static_cast<Interpolation>(interpolation);
      channel.times = numbers<float>(ch.at("times"));
      channel.values = numbers<float>(ch.at("values"));
      const size_t components = channel.path == ChannelPath::kWeights    ? targets[channel.node]
                                : channel.path == ChannelPath::kRotation ? 4
                                                                         : 3;
      require(!channel.times.empty() &&
              channel.values.size() == channel.times.size() * components *
                                           (channel.interpolation == Interpolation::kCubicSpline ? 3 : 1));
    }
  }
  return rig;
} catch (const json::exception&) {
  throw std::runtime_error("the rig section is not sound");
}

}  // namespace furrow::pipeline
