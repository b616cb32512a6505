#include "editor/ui/uv_view.h"

#include <algorithm>
#include <cmath>

#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

constexpr size_t kMostTriangles = 120000;  // drawn; of a denser mesh an even choice

}  // namespace

std::array<Float2, 3> onFirstTile(Float2 a, Float2 b, Float2 c) {
  const float u = std::floor((a.x + b.x + c.x) / 3.0f), v = std::floor((a.y + b.y + c.y) / 3.0f);
  return {{{a.x - u, a.y - v}, {b.x - u, b.y - v}, {c.x - u, c.y - v}}};
}

void drawUvLayout(const State& state, const Shown& shown, ImVec2 low, ImVec2 size) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float side = std::floor(std::min(size.x, size.y) - 5.0f * em());
  const ImVec2 corner = {std::floor(low.x + 0.5f * (size.x - side)),
                         std::floor(low.y + 0.5f * (size.y - side))};
  const ImVec2 end = {corner.x + side, corner.y + side};
  list->AddRectFilled(corner, end, IM_COL32(18, 19, 21, 255));
  for (int i = 1; i < 10; ++i) {
    const float at = side * static_cast<float>(i) / 10.0f;
    list->AddLine({corner.x + at, corner.y}, {corner.x + at, end.y}, Colors::kGrid);
    list->AddLine({corner.x, corner.y + at}, {end.x, corner.y + at}, Colors::kGrid);
  }
  const AssetView& asset = shown.view();
  const uint32_t layer = state.assetLayer(shown);
  const std::span<const uint8_t> mask =
      layer == pipeline::kNoIndex ? std::span<const uint8_t>() : asset.layers[layer].mask;
  const auto at = [&](Float2 uv) { return ImVec2(corner.x + side * uv.x, corner.y + side * uv.y); };
  const size_t step = asset.triangleCount() / kMostTriangles + 1;
  for (const Part& part : asset.parts) {
    if (!part.has_uvs) continue;
    for (size_t t = part.triangle_begin; t < part.triangle_end; t += step) {
      const uint32_t* v = &asset.indices[3 * t];
      const std::array<Float2, 3> uvs = onFirstTile(asset.uvs[v[0]], asset.uvs[v[1]], asset.uvs[v[2]]);
      uint32_t reach = 255;
      if (!mask.empty()) reach = std::max({mask[v[0]], mask[v[1]], mask[v[2]]});
      if (layer == pipeline::kNoIndex) reach = 0;
      const ImU32 color = reach > 8 ? IM_COL32(236, 160, 72, 60 + reach / 2) : IM_COL32(150, 152, 158, 70);
      list->AddTriangle(at(uvs[0]), at(uvs[1]), at(uvs[2]), color, 1.0f);
    }
  }
  list->AddRect(corner, end, IM_COL32(255, 255, 255, 90));
  list->AddText({corner.x, corner.y - 1.3f * em()}, Colors::kDim, "0, 0");
  const char* far_corner = "1, 1";
  list->AddText({end.x - ImGui::CalcTextSize(far_corner).x, end.y + 0.3f * em()}, Colors::kDim, far_corner);
}

}  // namespace furrow::editor::ui
