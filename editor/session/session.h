#pragma once

// One editing session without a screen: what is open, what is cooked from it, what moves it, and what went
// wrong. update() is called once a frame; nothing here waits.

#include <set>

#include "editor/document/document.h"
#include "editor/session/cook_worker.h"
#include "editor/session/file_watch.h"
#include "editor/session/player.h"
#include "editor/session/posed_surface.h"

namespace furrow::editor {

struct Message {
  enum class Kind : uint8_t { kNote, kWarning, kError };
  Kind kind = Kind::kNote;
  std::string text;  // one line
};

// An asset with what is worked out from it once.
struct Shown {
  explicit Shown(std::shared_ptr<const preview::LoadedAsset> asset)
      : loaded(std::move(asset)), surface(loaded->asset.view()) {}
  const AssetView& view() const { return loaded->asset.view(); }

  std::shared_ptr<const preview::LoadedAsset> loaded;
  PosedSurface surface;
};

class Session {
 public:
  // Opens an asset to look at, a source with the recipe that lies beside it under the same name (or the
  // default one), or a recipe with the source of its name. What cannot be opened is told in messages() and
  // leaves everything as it was; the cook goes on in the background.
  void open(const std::filesystem::path& file);
  void open(const std::filesystem::path& source, const std::filesystem::path& recipe);
  void close();

  void update(double seconds);  // of the clock since the last update

  const std::filesystem::path& source() const { return source_; }  // or the asset; empty: nothing is open
  bool editable() const { return editable_; }                      // a source, not a cooked asset
  Document document;
  Player player;

  // The last asset that was cooked without a fault; null before the first.
  const std::shared_ptr<Shown>& shown() const { return shown_; }
  bool current() const {
    return shown_number_ == wanted_;
  }  // shown() has all that was asked for, or its draft
  const pipeline::Recipe& resolved() const { return resolved_; }  // of shown(), all worked out
  const pipeline::CookReport& report() const { return report_; }
  bool cooking() const { return worker_.busy() || comparer_.busy(); }
  bool cooked() const { return worker_.done(); }  // a result waits for update()
  std::string stage() const { return (worker_.busy() ? worker_ : comparer_).stage(); }
  // Why what is shown is not what the document says; empty: it is, or will be.
  const std::string& recipeError() const { return recipe_error_; }  // of the recipe as it lies on disk
  const std::string& error() const { return recipe_error_.empty() ? error_ : recipe_error_; }

  // Another asset or recipe for the same source, to compare with; its faults are messages.
  void compareWith(const std::filesystem::path& file);
  void endComparison();
  const std::filesystem::path& compared() const { return compared_; }
  const std::shared_ptr<Shown>& comparison() const { return comparison_; }

  // Responses for shown(): those of the document where a layer of this name has lambda and beta given.
  std::vector<Response> responses(const Shown& of) const;

  void save(const std::filesystem::path& recipe);  // of the document; faults are messages
  void cookTo(const std::filesystem::path& asset);
  // The recipe or a painted image changed on disk while edits were not saved, or a recipe that cannot be read
  // would be replaced; reload() drops the edits (they can be had back with undo), keep() lets the next save
  // replace the files.
  bool conflict() const { return conflict_; }
  void reload();
  void keep();

  const std::vector<Message>& messages() const { return messages_; }  // the latest ones
  uint64_t told() const { return told_; }                             // how many there were in all
  bool toldErrorSince(uint64_t told) const;                           // that is still among messages()
  void tell(Message::Kind kind, const std::string& text);
  void clearMessages() { messages_.clear(); }

 private:
  void request();
  void takeResults();
  void lookAtFiles();
  void watchFiles();
  void believe();  // in the faults that are doubted

  std::filesystem::path source_, compared_;
  bool editable_ = false, conflict_ = false, reread_ = false;
  std::shared_ptr<Shown> shown_, comparison_;
  pipeline::Recipe resolved_;
  pipeline::CookReport report_;
  std::string error_, recipe_error_;  // error_: of the last cook
  // The same just after a file changed: it may be half a file, and more to come.
  std::string error_doubt_, recipe_doubt_;
  std::vector<Message> messages_;
  uint64_t told_ = 0;
  std::set<std::string> warned_;  // warnings that were told
  std::vector<std::filesystem::path> dependencies_;
  FileWatch watch_;
  double since_look_ = 0.0, since_change_ = 0.0;
  uint64_t number_ = 0, wanted_ = 0, shown_number_ = 0;  // of requests
  Content asked_;                                        // what the last request was for
  CookWorker worker_, comparer_;
};

}  // namespace furrow::editor
