#include "editor/document/document.h"

#include <span>

#include "pipeline/pack/output_file.h"

namespace furrow::editor {
namespace {

const std::string kNothing;

}  // namespace

bool same(const Content& a, const Content& b) {
  const std::filesystem::path file = "/recipe.json";  // the same for both
  return a.images == b.images && pipeline::recipeText(a.recipe, file) == pipeline::recipeText(b.recipe, file);
}

Document::Document(Content content, std::filesystem::path file, bool saved)
    : content_(std::move(content)), file_(std::move(file)), saved_(saved ? 0 : ~uint64_t{0}) {}

void Document::become(Content content, uint64_t revision) {
  content_ = std::move(content);
  revision_ = revision;
}

void Document::apply(Content next, const std::string& what) {
  if (same(content_, next)) return;
  const bool goes_on = gesture_ && !undo_.empty() && undo_.back().what == what && redo_.empty();
  if (!goes_on) {
    if (undo_.size() == kMostSteps) undo_.erase(undo_.begin());
    undo_.push_back({what, std::move(content_), revision_});
    redo_.clear();
  }
  gesture_ = true;
  become(std::move(next), ++newest_);
}

const std::string& Document::undoName() const {
  return undo_.empty() ? kNothing : undo_.back().what;
}
const std::string& Document::redoName() const {
  return redo_.empty() ? kNothing : redo_.back().what;
}

void Document::undo() {
  if (undo_.empty()) return;
  Step step = std::move(undo_.back());
  undo_.pop_back();
  redo_.push_back({step.what, std::move(content_), revision_});
  become(std::move(step.content), step.revision);
  gesture_ = false;
}

void Document::redo() {
  if (redo_.empty()) return;
  Step step = std::move(redo_.back());
  redo_.pop_back();
  undo_.push_back({step.what, std::move(content_), revision_});
  become(std::move(step.content), step.revision);
  gesture_ = false;
}

void Document::save(const std::filesystem::path& file) {
  for (const auto& [path, image] : content_.images) {
    const auto written = written_.find(path);
    if (written != written_.end() && written->second == image) continue;
    pipeline::writeImage(path, pipeline::toFloats(*image));
    written_[path] = image;
  }
  const std::string text = pipeline::recipeText(content_.recipe, file);
  pipeline::writeFile(file, std::as_bytes(std::span(text)));
  file_ = file;
  content_.recipe.file = file;
  saved_ = revision_;
  gesture_ = false;
}

void Document::reloaded(Content content) {
  undo_.push_back({"change on disk", std::move(content_), revision_});
  redo_.clear();
  become(std::move(content), ++newest_);
  saved_ = revision_;
  gesture_ = false;
}

}  // namespace furrow::editor
