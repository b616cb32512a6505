#include "editor/session/cook_worker.h"

#include <algorithm>

#include "pipeline/cook/cook.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/pack/output_file.h"

namespace furrow::editor {
namespace {

constexpr uint32_t kDraftMapSize = 256;

}  // namespace

CookWorker::CookWorker() : thread_([this] { work(); }) {}

CookWorker::~CookWorker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  woken_.notify_all();
}

void CookWorker::request(CookRequest request) {
  {
    const std::lock_guard lock(mutex_);
    if (request.output.empty())
      waiting_ = std::move(request);
    else
      outputs_.push_back(std::move(request));
  }
  woken_.notify_all();
}

std::optional<CookResult> CookWorker::take() {
  const std::lock_guard lock(mutex_);
  if (results_.empty()) return std::nullopt;
  CookResult result = std::move(results_.front());
  results_.pop_front();
  return result;
}

void CookWorker::proceed() {
  {
    const std::lock_guard lock(mutex_);
    if (!results_.empty()) return;
    held_ = false;
  }
  woken_.notify_all();
}

bool CookWorker::busy() const {
  const std::lock_guard lock(mutex_);
  return at_work_ || waiting_ || !outputs_.empty() || !results_.empty();
}

bool CookWorker::done() const {
  const std::lock_guard lock(mutex_);
  return !results_.empty();
}

std::string CookWorker::stage() const {
  const std::lock_guard lock(mutex_);
  return stage_;
}

void CookWorker::enter(const char* stage) {
  const std::lock_guard lock(mutex_);
  if (stop_ || (may_cancel_ && waiting_)) throw Cancelled();
  stage_ = stage;
}

void CookWorker::work() {
  for (;;) {
    CookRequest request;
    {
      std::unique_lock lock(mutex_);
      at_work_ = false;
      stage_.clear();
      woken_.wait(lock, [this] { return stop_ || waiting_ || !outputs_.empty(); });
      if (stop_) return;
      at_work_ = true;
      if (waiting_) {
        request = std::move(*waiting_);
        waiting_.reset();
      } else {
        request = std::move(outputs_.front());
        outputs_.pop_front();
      }
    }
    const bool drafted = request.draft && (request.content.recipe.map_size == 0 ||
                                           request.content.recipe.map_size > kDraftMapSize);
    try {
      if (drafted) {
        cook(request, true);
        waitUntilShown();
      }
      cook(request, false);
    } catch (const Cancelled&) {
    }
  }
}

void CookWorker::waitUntilShown() {
  std::unique_lock lock(mutex_);
  woken_.wait(lock, [this] { return stop_ || waiting_ || !held_; });
}

pipeline::SourceScene CookWorker::scene(const std::filesystem::path& source) {
  const bool fresh = source == scene_file_ &&
                     std::all_of(scene_states_.begin(), scene_states_.end(),
                                 [](const auto& entry) { return stateOf(entry.first) == entry.second; });
  if (!fresh) {
    scene_file_.clear();
    scene_states_.clear();
    memory_.forgetScene();
    // Before they are read: what is written meanwhile is a change.
    for (const std::filesystem::path& file : pipeline::importedFiles(source))
      scene_states_.emplace(file, stateOf(file));
    scene_ = pipeline::import(source);
    scene_file_ = source;
  }
  return scene_;
}

void CookWorker::cook(const CookRequest& request, bool draft) {
  CookResult result;
  result.revision = request.revision;
  result.draft = draft;
  result.output = request.output;
  {
    const std::lock_guard lock(mutex_);
    may_cancel_ = !draft && request.draft;
  }
  try {
    enter("reading");
    if (preview::looksLikeAsset(request.source)) {
      result.asset = std::make_shared<preview::LoadedAsset>(preview::loadAsset(request.source));
      result.dependencies = {request.source};
    } else {
      pipeline::CookOptions options;
      options.geometry =
          request.output.empty() ? pipeline::GeometryCodec::kRaw : pipeline::GeometryCodec::kDraco;
      options.threads = std::max(1u, std::thread::hardware_concurrency());
      options.progress = [this](const char* stage) { enter(stage); };
      options.images = request.content.images;
      options.memory = &memory_;
      pipeline::Recipe recipe = request.content.recipe;
      if (draft) recipe.map_size = kDraftMapSize;
      pipeline::Cooked cooked = pipeline::cook(scene(request.source), recipe, options);
      result.asset = std::make_shared<preview::LoadedAsset>(
          preview::withRig(request.source, cooked.bytes, std::move(cooked.asset)));
      if (!request.output.empty()) pipeline::writeFile(request.output, cooked.bytes);
      result.recipe = std::move(cooked.recipe);
      result.report = std::move(cooked.report);
      result.dependencies = std::move(cooked.dependencies);
    }
  } catch (const std::bad_alloc&) {
    result.asset.reset();
    result.error = request.source.string() + ": out of memory: close other programs or open a smaller file";
  } catch (const std::exception& error) {
    result.asset.reset();
    result.error = error.what();
  }
  if (!preview::looksLikeAsset(request.source)) result.read = scene_states_;
  const bool failed = !result.asset;
  {
    const std::lock_guard lock(mutex_);
    results_.push_back(std::move(result));
    held_ = draft;
  }
  if (draft && failed) throw Cancelled();  // the whole cook would fail in the same way
}

}  // namespace furrow::editor
