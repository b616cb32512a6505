#include "editor/document/document.h"

#include <map>
#include <span>

#include "pipeline/pack/output_file.h"

namespace furrow::editor {
namespace {

namespace fs = std::filesystem;

const std::string kNothing;

// Where a layer names an image that can be painted.
std::vector<fs::path*> imagesOf(pipeline::LayerRecipe& layer) {
  std::vector<fs::path*> files;
  if (auto* mask = std::get_if<pipeline::MaskTexture>(&layer.mask)) files.push_back(&mask->texture);
  if (auto* flow = std::get_if<pipeline::DirectionTexture>(&layer.direction)) files.push_back(&flow->texture);
  if (layer.bias) files.push_back(&layer.bias->texture);
  return files;
}

// The images painted for recipe `from`, named for recipe `to`.
Content movedBeside(Content content, const fs::path& from, const fs::path& to) {
  std::map<fs::path, fs::path> moved;
  const std::string stem = from.stem().string() + "_";
  for (const auto& [file, image] : content.images) {
    std::string name = file.filename().string();
    if (name.starts_with(stem)) name = to.stem().string() + "_" + name.substr(stem.size());
    moved[file] = to.parent_path() / name;
  }
  pipeline::Images images;
  for (const auto& [file, image] : content.images) images[moved[file]] = image;
  content.images = std::move(images);
  for (pipeline::LayerRecipe& layer : content.recipe.layers)
    for (fs::path* file : imagesOf(layer))
      if (const auto found = moved.find(*file); found != moved.end()) *file = found->second;
  return content;
}

}  // namespace

bool same(const Content& a, const Content& b) {
  const fs::path file = "/recipe.json";  // the same for both
  return a.images == b.images && pipeline::recipeText(a.recipe, file) == pipeline::recipeText(b.recipe, file);
}

Document::Document(Content content, fs::path file, bool saved)
    : content_(std::move(content)), file_(std::move(file)), saved_(saved ? 0 : ~uint64_t{0}) {}

Document::Step Document::stepBack(const std::string& what, const Content& next) const {
  return {what, content_.recipe, changesBetween(next.images, content_.images), revision_};
}

void Document::pushUndo(Step step) {
  if (undo_.size() >= kMostSteps) undo_.erase(undo_.begin());
  undo_.push_back(std::move(step));
  redo_.clear();
}

void Document::apply(Content next, const std::string& what) {
  if (same(content_, next)) return;
  const bool goes_on = gesture_ && !undo_.empty() && undo_.back().what == what && redo_.empty();
  // A drag edits the recipe alone: images change by strokes, each a step.
  if (!goes_on || next.images != content_.images) pushUndo(stepBack(what, next));
  gesture_ = true;
  content_ = std::move(next);
  revision_ = ++newest_;
}

const std::string& Document::undoName() const {
  return undo_.empty() ? kNothing : undo_.back().what;
}
const std::string& Document::redoName() const {
  return redo_.empty() ? kNothing : redo_.back().what;
}

void Document::take(std::vector<Step>& from, std::vector<Step>& to) {
  if (from.empty()) return;
  Step step = std::move(from.back());
  from.pop_back();
  Content next{std::move(step.recipe), changed(content_.images, step.images)};
  to.push_back(stepBack(step.what, next));
  content_ = std::move(next);
  revision_ = step.revision;
  gesture_ = false;
}

void Document::undo() {
  take(undo_, redo_);
}
void Document::redo() {
  take(redo_, undo_);
}

size_t Document::historyBytes() const {
  size_t bytes = 0;
  for (const auto* steps : {&undo_, &redo_})
    for (const Step& step : *steps) bytes += byteCount(step.images);
  return bytes;
}

void Document::save(const fs::path& file) {
  const bool elsewhere = file != file_ && !content_.images.empty();
  Content next = elsewhere ? movedBeside(content_, file_, file) : content_;
  for (pipeline::LayerRecipe& layer : next.recipe.layers)
    for (const fs::path* path : imagesOf(layer)) {
      const auto image = next.images.find(*path);
      if (image == next.images.end() || written_[*path] == image->second) continue;
      pipeline::writeImage(*path, pipeline::toFloats(*image->second));
      written_[*path] = image->second;
    }
  const std::string text = pipeline::recipeText(next.recipe, file);
  pipeline::writeFile(file, std::as_bytes(std::span(text)));
  if (elsewhere) {
    pushUndo(stepBack("save under another name", next));
    content_ = std::move(next);
    revision_ = ++newest_;
  }
  file_ = file;
  content_.recipe.file = file;
  saved_ = revision_;
  gesture_ = false;
}

void Document::reloaded(Content content) {
  pushUndo(stepBack("change on disk", content));
  content_ = std::move(content);
  std::erase_if(written_, [this](const auto& entry) { return !content_.images.contains(entry.first); });
  saved_ = revision_ = ++newest_;
  gesture_ = false;
}

}  // namespace furrow::editor
