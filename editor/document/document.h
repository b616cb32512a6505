#pragma once

// What the artist edits: a recipe and the images painted for it, with undo and redo. Knows nothing of the
// screen.

#include <filesystem>
#include <string>
#include <vector>

#include "editor/document/image_change.h"
#include "pipeline/recipe/recipe.h"

namespace furrow::editor {

// A value: copies are cheap, images are shared.
struct Content {
  pipeline::Recipe recipe;
  pipeline::Images images;  // painted, by the path they are saved under; they need not be there yet
};

// Whether a save would write the same.
bool same(const Content& a, const Content& b);

class Document {
 public:
  Document() = default;
  // `file`: the recipe's, which need not exist yet; `saved`: whether `content` is what lies there.
  Document(Content content, std::filesystem::path file, bool saved);

  const Content& content() const { return content_; }
  const pipeline::Recipe& recipe() const { return content_.recipe; }
  const std::filesystem::path& file() const { return file_; }
  uint64_t revision() const { return revision_; }  // another number after every change
  bool dirty() const { return saved_ != revision_; }

  // `what` names the edit in the menu ("beta of forehead"). Edits in a row with the same `what` are one step
  // until endGesture(): a drag is one edit. Nothing happens where the content is the same.
  void apply(Content next, const std::string& what);
  void endGesture() { gesture_ = false; }

  // The names of the edits that undo() and redo() would take back and make again; empty: there is none.
  const std::string& undoName() const;
  const std::string& redoName() const;
  void undo();
  void redo();

  size_t historyBytes() const;  // of the images that undo() and redo() need

  // Writes the images of layers that changed since they were read or saved, then the recipe, to `file`: each
  // appears whole or not at all, and the recipe last, so that it never names an image that is not there.
  // Throws pipeline::Error (kEnvironment); the document then stays as it was and stays dirty. Under another
  // name the images painted here go with the recipe, into its folder and under its name, and those of the old
  // one stay as they are; that is an edit, which can be undone.
  void save(const std::filesystem::path& file);
  // The next save writes every image, or this one, whatever lies on disk.
  void overwrite() { written_.clear(); }
  void overwrite(const std::filesystem::path& image) { written_.erase(image); }
  // What lies on disk was read anew and becomes the content, as an edit that needs no saving.
  void reloaded(Content content);

 private:
  // From the content to that before the edit (undo) or after it (redo).
  struct Step {
    std::string what;
    pipeline::Recipe recipe;
    ImageChanges images;
    uint64_t revision = 0;
  };
  static constexpr size_t kMostSteps = 200;

  // The step back to the content, from `next`.
  Step stepBack(const std::string& what, const Content& next) const;
  void pushUndo(Step step);
  void take(std::vector<Step>& from, std::vector<Step>& to);

  Content content_;
  std::filesystem::path file_;
  std::vector<Step> undo_, redo_;
  pipeline::Images written_;  // what lies on disk
  uint64_t revision_ = 0, newest_ = 0, saved_ = 0;
  bool gesture_ = false;
};

}  // namespace furrow::editor
