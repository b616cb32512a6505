#pragma once

// Imports and cooks in the background.

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "editor/document/document.h"
#include "editor/preview/loaded_asset.h"
#include "editor/session/file_watch.h"
#include "pipeline/cook/cook_memory.h"
#include "pipeline/cook/cook_report.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::editor {

struct CookRequest {
  std::filesystem::path source;  // a mesh to cook, or a .furrow to load
  Content content;               // `images` stand in for the files of their names
  uint64_t revision = 0;         // comes back with the result
  bool draft = false;            // a quick cook with small maps is shown first
  std::filesystem::path output;  // if not empty, the asset is written there, Draco-encoded
};

struct CookResult {
  uint64_t revision = 0;
  bool draft = false;  // the whole cook is still under way
  std::filesystem::path output;
  std::shared_ptr<const preview::LoadedAsset> asset;  // null: it failed
  std::string error;                                  // "FILE: what is wrong: what to do"
  pipeline::Recipe recipe;                            // with all that was left open worked out
  pipeline::CookReport report;
  std::vector<std::filesystem::path> dependencies;
  FileStates read;  // the source and the files that it names, before they were read
};

// One thread and at most one request that waits: a newer one takes its place, and ends a cook whose draft was
// shown. The whole cook leaves the processors to the first picture of its draft: it waits for proceed().
// Requests with an output are all done, in their order. The scene of the last source is kept until its
// files change.
class CookWorker {
 public:
  CookWorker();
  ~CookWorker();  // waits for the end of the stage at work

  void request(CookRequest request);
  std::optional<CookResult> take();  // the oldest result not yet taken
  void proceed();                    // the draft that was taken has been shown: the whole cook may begin
  bool busy() const;                 // something waits or is at work
  bool done() const;                 // a result can be taken
  std::string stage() const;         // of the cook at work, for people; empty: none

 private:
  struct Cancelled {};

  void work();
  void cook(const CookRequest& request, bool draft);
  pipeline::SourceScene scene(const std::filesystem::path& source);
  void waitUntilShown();
  void enter(const char* stage);  // throws Cancelled if the work has become pointless

  mutable std::mutex mutex_;
  std::condition_variable woken_;
  std::optional<CookRequest> waiting_;
  std::deque<CookRequest> outputs_;
  std::deque<CookResult> results_;
  std::string stage_;
  bool at_work_ = false, may_cancel_ = false, held_ = false, stop_ = false;

  // Of the worker alone.
  std::filesystem::path scene_file_;
  FileStates scene_states_;
  pipeline::SourceScene scene_;
  pipeline::CookMemory memory_;

  std::jthread thread_;
};

}  // namespace furrow::editor
