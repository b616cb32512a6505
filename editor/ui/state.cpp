#include "editor/ui/state.h"

namespace furrow::editor::ui {

uint32_t State::documentLayer() const {
  const std::vector<pipeline::LayerRecipe>& layers = session.document.recipe().layers;
  for (uint32_t l = 0; l < layers.size(); ++l)
    if (layers[l].name == layer) return l;
  return pipeline::kNoIndex;
}

uint32_t State::assetLayer(const Shown& shown) const {
  for (uint32_t l = 0; l < shown.view().layerCount(); ++l)
    if (shown.view().layers[l].name == layer) return l;
  return pipeline::kNoIndex;
}

std::string State::brief(std::string text) const {
  const std::string folder = session.source().parent_path().string() + "/";
  for (size_t at = text.find(folder); folder.size() > 1 && at != std::string::npos;
       at = text.find(folder, at))
    text.erase(at, folder.size());
  return text;
}

void State::edit(const std::string& what, const std::function<void(pipeline::LayerRecipe&)>& change) {
  const uint32_t selected = documentLayer();
  if (!session.editable() || selected == pipeline::kNoIndex) return;
  Content content = session.document.content();
  change(content.recipe.layers[selected]);
  session.document.apply(std::move(content), what);
}

void State::editAll(const std::string& what, const std::function<void(pipeline::Recipe&)>& change) {
  if (!session.editable()) return;
  Content content = session.document.content();
  change(content.recipe);
  session.document.apply(std::move(content), what);
}

void State::take(Tool to) {
  constexpr preview::View kViews[] = {preview::View::kBeauty, preview::View::kBias, preview::View::kMask,
                                      preview::View::kDirection, preview::View::kDirection};
  tool = to;
  cursor.reset();
  looks[0].view = static_cast<int>(kViews[static_cast<size_t>(to)]);
}

}  // namespace furrow::editor::ui
