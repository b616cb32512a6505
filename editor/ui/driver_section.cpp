#include "editor/ui/driver_section.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "editor/ui/plot.h"
#include "editor/ui/widgets.h"
#include "furrow/drivers.h"
#include "pipeline/recipe/arkit.h"

namespace furrow::editor::ui {
namespace {

using pipeline::DriverRecipe;
using pipeline::LayerRecipe;
using Curve = std::vector<std::array<double, 2>>;

constexpr float kGrab = 0.6f;  // em from a point that still mean it
constexpr double kApart = 0.01;
constexpr size_t kMostPoints = 64;

double legible(float value) {
  return std::round(double{value} * 100.0) / 100.0;
}

// Keeps the points in their order; false where there is no room for them.
bool put(Curve& curve, size_t index, ImVec2 values) {
  const double low = index > 0 ? curve[index - 1][0] + kApart : -100.0,
               high = index + 1 < curve.size() ? curve[index + 1][0] - kApart : 100.0;
  if (low > high) return false;
  const std::array<double, 2> to = {std::clamp(legible(values.x), low, high), legible(values.y)};
  if (curve[index] == to) return false;
  curve[index] = to;
  return true;
}

// The index of the new point, or the curve's size where it would stand on another.
size_t insert(Curve& curve, ImVec2 values) {
  const double x = legible(values.x);
  const auto after = std::ranges::find_if(curve, [&](const auto& point) { return point[0] >= x; });
  if (curve.size() >= kMostPoints || (after != curve.end() && (*after)[0] < x + kApart) ||
      (after != curve.begin() && (*(after - 1))[0] > x - kApart))
    return curve.size();
  return static_cast<size_t>(curve.insert(after, {x, legible(values.y)}) - curve.begin());
}

float bent(const Curve& curve, float weight) {
  std::vector<Float2> points;
  for (const auto& [in, out] : curve) points.push_back({static_cast<float>(in), static_cast<float>(out)});
  return drive({0, 1.0f, points}, weight);
}

bool drawCurve(const std::string& id, Curve& curve) {
  ImVec2 least(0.0f, -1.0f), most(1.0f, 1.0f);
  for (const auto& [in, out] : curve) {
    least = {std::min(least.x, static_cast<float>(in)), std::min(least.y, static_cast<float>(out))};
    most = {std::max(most.x, static_cast<float>(in)), std::max(most.y, static_cast<float>(out))};
  }
  const float rim = 0.06f;
  const Plot plot(6.6f * em(), {least.x - rim, least.y - rim}, {most.x + rim, most.y + rim});
  ImGui::InvisibleButton(("##" + id).c_str(), plot.size(),
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  mark(id.c_str());
  tooltip(
      "What the morph target's weight (0 to 1, to the right) counts as (-1 to 1, upwards): straight between "
      "the "
      "points, level outside. Drag a point, click to add one, right click to remove one");
  const ImVec2 mouse = ImGui::GetMousePos();
  const auto screen = [&](const std::array<double, 2>& point) {
    return plot.at(static_cast<float>(point[0]), static_cast<float>(point[1]));
  };
  const auto grabbed = std::ranges::min_element(curve, {}, [&](const std::array<double, 2>& point) {
    return std::hypot(screen(point).x - mouse.x, screen(point).y - mouse.y);
  });
  const bool near = grabbed != curve.end() &&
                    std::hypot(screen(*grabbed).x - mouse.x, screen(*grabbed).y - mouse.y) < kGrab * em();
  bool changed = false;
  int* held = ImGui::GetStateStorage()->GetIntRef(ImGui::GetID((id + ".held").c_str()), -1);
  if (ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    const size_t count = curve.size();
    const size_t index =
        near ? static_cast<size_t>(grabbed - curve.begin()) : insert(curve, plot.valuesAt(mouse));
    changed = curve.size() != count;
    *held = index < curve.size() ? static_cast<int>(index) : -1;
  } else if (ImGui::IsItemClicked(ImGuiMouseButton_Right) && near && curve.size() > 1) {
    curve.erase(grabbed);
    changed = true;
  } else if (ImGui::IsItemActive() && *held >= 0 && *held < static_cast<int>(curve.size())) {
    if (ImGui::GetIO().MouseDelta.x != 0.0f || ImGui::GetIO().MouseDelta.y != 0.0f)
      changed = put(curve, static_cast<size_t>(*held), plot.valuesAt(mouse));
  } else {
    *held = -1;
  }

  for (float in : {0.0f, 0.5f, 1.0f}) plot.lineUp(in, false, in == 0.0f ? "0" : in == 1.0f ? "1" : "0.5");
  for (float out : {-1.0f, 0.0f, 1.0f}) plot.lineAcross(out, out == 0.0f);
  plot.topLabel("+1");
  plot.bottomLabel("-1");
  ImDrawList* list = ImGui::GetWindowDrawList();
  std::vector<ImVec2> line = {plot.at(least.x - rim, bent(curve, least.x - rim))};
  for (const auto& point : curve) line.push_back(screen(point));
  line.push_back(plot.at(most.x + rim, bent(curve, most.x + rim)));
  list->AddPolyline(line.data(), static_cast<int>(line.size()), Colors::kAccent, 0, 2.0f);
  for (const auto& point : curve) list->AddCircleFilled(screen(point), 0.28f * em(), Colors::kAccent);
  return changed;
}

// For the keyboard, and for exact values.
bool drawPoints(const std::string& id, Curve& curve) {
  bool changed = false;
  for (size_t i = 0; i < curve.size(); ++i) {
    const std::string number = std::to_string(i + 1), point = id + "." + number;
    ImVec2 values(static_cast<float>(curve[i][0]), static_cast<float>(curve[i][1]));
    row(("  Point " + number).c_str());
    const float half = 0.5f * (ImGui::CalcItemWidth() - ImGui::GetStyle().ItemInnerSpacing.x);
    ImGui::SetNextItemWidth(half);
    bool moved = bareSlider((point + ".in").c_str(), values.x, 0.0f, 1.0f, "%.2f",
                            "The morph target's weight at this point, 0 to 1, between the points beside it");
    ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
    ImGui::SetNextItemWidth(half);
    moved |= bareSlider((point + ".out").c_str(), values.y, -1.0f, 1.0f, "%.2f",
                        "What that weight counts as, -1 to 1");
    if (moved) changed |= put(curve, i, values);
  }
  return changed;
}

void drawDriver(State& state, const DriverRecipe& driver, size_t index) {
  const std::string id = "drivers." + driver.morph;
  const auto edit = [&](const std::string& what, const auto& change) {
    state.edit(what + " of " + driver.morph, [&](LayerRecipe& edited) { change(edited.drivers[index]); });
  };
  bool bends = !driver.curve.empty();
  if (checkbox((id + ".bent").c_str(), "  Curve", bends,
               "Bends what the morph target's weight counts as, by points on a curve; without one it counts "
               "as it is"))
    edit("Curve", [&](DriverRecipe& edited) {
      edited.curve = bends ? Curve{{0.0, 0.0}, {1.0, 1.0}} : Curve();
    });
  if (driver.curve.empty()) return;
  Curve curve = driver.curve;
  const bool dragged = drawCurve(id + ".curve", curve);
  if (drawPoints(id + ".curve", curve) || dragged)
    edit("Curve", [&](DriverRecipe& edited) { edited.curve = curve; });
}

}  // namespace

void drawDrivers(State& state, const LayerRecipe& layer) {
  if (!section("section.drivers", "Drivers",
               "Morph targets that raise the layer whether or not it is squeezed", false))
    return;
  std::vector<std::string> tables = pipeline::driverTables();
  tables.insert(tables.begin(), "(own list)");
  std::string table = layer.driver_table.empty() ? tables.front() : layer.driver_table;
  if (choice("drivers.table", "Ready table", table, tables,
             "A table of ARKit's face shapes for a region of the face, or a list of your own"))
    state.edit("Drivers of " + layer.name, [&](LayerRecipe& edited) {
      edited.driver_table = table == tables.front() ? std::string() : table;
      edited.drivers.clear();
    });
  if (!layer.driver_table.empty()) return;
  for (size_t d = 0; d < layer.drivers.size(); ++d) {
    const std::string id = "drivers." + layer.drivers[d].morph;
    float gain = static_cast<float>(layer.drivers[d].gain);
    ImGui::PushID(static_cast<int>(d));
    if (slider(id.c_str(), layer.drivers[d].morph.c_str(), gain, -2.0f, 2.0f, "%.2f",
               "Weight that the morph target at 1 adds to the layer, -2 to 2. Right click: remove"))
      state.edit("Gain of " + layer.drivers[d].morph,
                 [&](LayerRecipe& edited) { edited.drivers[d].gain = double{gain}; });
    const bool removed = ImGui::IsItemClicked(ImGuiMouseButton_Right);
    if (!removed) drawDriver(state, layer.drivers[d], d);
    ImGui::PopID();
    if (removed) {
      state.edit("Remove driver", [&](LayerRecipe& edited) {
        edited.drivers.erase(edited.drivers.begin() + static_cast<std::ptrdiff_t>(d));
      });
      return;
    }
  }
  std::vector<std::string> names;
  if (state.session.shown())
    for (const Morph& morph : state.session.shown()->view().morphs)
      if (!morph.name.empty() && std::ranges::find(names, morph.name) == names.end())
        names.emplace_back(morph.name);
  if (names.empty()) {
    ImGui::TextDisabled("the character has no morph targets");
    return;
  }
  std::string chosen;
  if (choice("drivers.add", "Add", chosen, names, "A morph target whose weight is added to the layer's"))
    state.edit("Add driver", [&](LayerRecipe& edited) { edited.drivers.push_back({chosen}); });
}

}  // namespace furrow::editor::ui
