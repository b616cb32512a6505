#include "editor/session/session.h"

#include <algorithm>
#include <utility>

#include "pipeline/error.h"

namespace furrow::editor {
namespace {

namespace fs = std::filesystem;

constexpr double kLookEvery = 0.1;    // seconds
constexpr double kHalfWritten = 0.3;  // that a file may stay without a change of its size or time
constexpr size_t kMostMessages = 500;
constexpr const char* kSourceKinds[] = {".glb", ".gltf", ".obj", ".ply", ".stl", ".off"};

fs::path whole(const fs::path& file) {
  return fs::absolute(file).lexically_normal();
}

bool isFile(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

// Everything a cook depends on: lambda and beta reach the picture without one.
Content withoutResponses(Content content) {
  for (pipeline::LayerRecipe& layer : content.recipe.layers)
    if (!layer.fit && layer.response.curve == Curve::kLarsson) layer.response = {};
  return content;
}

std::vector<fs::path> imagesOf(const pipeline::Recipe& recipe) {
  std::vector<fs::path> files;
  const auto add = [&](const fs::path& file) {
    if (!file.empty()) files.push_back(file);
  };
  for (const pipeline::LayerRecipe& layer : recipe.layers) {
    if (const auto* mask = std::get_if<pipeline::MaskTexture>(&layer.mask)) add(mask->texture);
    if (const auto* flow = std::get_if<pipeline::DirectionTexture>(&layer.direction)) add(flow->texture);
    if (layer.bias) add(layer.bias->texture);
    for (const pipeline::Map* map : {&layer.compress, &layer.stretch}) {
      if (const auto* normal = std::get_if<pipeline::MapNormal>(map)) add(normal->texture);
      if (const auto* height = std::get_if<pipeline::MapHeight>(map)) add(height->texture);
    }
    for (const pipeline::MapFinish* finish : {&layer.compress_finish, &layer.stretch_finish})
      if (finish->shading) add(*finish->shading);
  }
  return files;
}

}  // namespace

void Session::tell(Message::Kind kind, const std::string& text) {
  if (messages_.size() == kMostMessages) messages_.erase(messages_.begin());
  messages_.push_back({kind, text});
  ++told_;
}

bool Session::toldErrorSince(uint64_t told) const {
  const auto latest = static_cast<std::ptrdiff_t>(std::min<uint64_t>(told_ - told, messages_.size()));
  return std::any_of(messages_.end() - latest, messages_.end(),
                     [](const Message& message) { return message.kind == Message::Kind::kError; });
}

void Session::open(const fs::path& file) {
  if (file.extension() == ".json") {
    for (const char* kind : kSourceKinds) {
      fs::path source = file;
      source.replace_extension(kind);
      if (isFile(source)) return open(source, file);
    }
    tell(Message::Kind::kError, file.string() +
                                    ": a recipe does not say what it is for, and no mesh of its name lies "
                                    "beside it: open the mesh, or put the recipe beside it");
    return;
  }
  fs::path recipe = file;
  recipe.replace_extension(".json");
  open(file, preview::looksLikeAsset(file) ? fs::path() : recipe);
}

void Session::open(const fs::path& source, const fs::path& recipe) {
  if (!isFile(source)) {
    tell(Message::Kind::kError, source.string() + ": there is no such file: check the path");
    return;
  }
  const bool asset = preview::looksLikeAsset(source);
  Content content{pipeline::defaultRecipe(), {}};
  bool found = false;
  if (!asset && isFile(recipe)) {
    try {
      content.recipe = pipeline::readRecipe(recipe);
      found = true;
    } catch (const pipeline::Error& error) {
      tell(Message::Kind::kError, error.what());
      return;
    }
  }
  close();
  source_ = whole(source);
  editable_ = !asset;
  if (!asset) content.recipe.file = whole(recipe);
  // A default recipe that nobody edited needs no saving.
  document = Document(std::move(content), asset ? fs::path() : whole(recipe), true);
  if (found) tell(Message::Kind::kNote, recipe.string() + ": the recipe beside the mesh is used");
  request();
  watchFiles();
}

void Session::close() {
  source_.clear();
  shown_.reset();
  endComparison();
  resolved_ = {};
  report_ = {};
  warned_.clear();
  error_.clear();
  recipe_error_.clear();
  error_doubt_.clear();
  recipe_doubt_.clear();
  since_change_ = kHalfWritten;
  dependencies_.clear();
  editable_ = conflict_ = reread_ = false;
  document = Document();
  player = Player();
  wanted_ = ++number_;
}

void Session::request() {
  asked_ = withoutResponses(document.content());
  wanted_ = ++number_;
  error_doubt_.clear();
  worker_.request({source_, document.content(), wanted_, true, {}});
}

void Session::update(double seconds) {
  worker_.proceed();  // the frame of the last update was drawn
  takeResults();
  if (source_.empty()) return;
  since_look_ += seconds;
  since_change_ += seconds;
  if (since_look_ >= kLookEvery) {
    since_look_ = 0.0;
    lookAtFiles();
  }
  if (since_change_ >= kHalfWritten) believe();
  if (editable_ && (reread_ || !same(asked_, withoutResponses(document.content())))) {
    reread_ = false;
    request();
    watchFiles();
  }
  if (shown_) player.advance(shown_->loaded->rig, seconds);
}

void Session::believe() {
  for (const auto& [doubt, error] :
       {std::pair(&recipe_doubt_, &recipe_error_), std::pair(&error_doubt_, &error_)}) {
    if (doubt->empty()) continue;
    *error = std::exchange(*doubt, {});
    tell(Message::Kind::kError, *error);
  }
}

void Session::takeResults() {
  while (std::optional<CookResult> result = worker_.take()) {
    if (!result->output.empty()) {
      if (result->error.empty())
        tell(Message::Kind::kNote, result->output.string() + ": cooked, " +
                                       std::to_string(result->report.bytes / 1024) + " KiB" +
                                       (document.dirty() ? "; the recipe is not saved yet" : ""));
      else
        tell(Message::Kind::kError, result->error);
      continue;
    }
    if (result->revision < wanted_ && !(result->draft && result->asset)) continue;  // a newer one is coming
    watch_.watchSince(result->read);
    if (!result->asset) {
      if (result->revision == wanted_) error_doubt_ = result->error;
      if (dependencies_.empty())
        for (const auto& [file, state] : result->read) dependencies_.push_back(file);
      watchFiles();
      continue;
    }
    if (result->revision == wanted_) error_.clear();
    const bool first = !shown_;
    shown_ = std::make_shared<Shown>(result->asset);
    shown_number_ = result->revision;
    if (first && !result->asset->rig.clips.empty()) player.clip = clipKey(result->asset->rig, 0);
    for (const std::string& warning : result->report.warnings)
      if (warned_.insert(warning).second) tell(Message::Kind::kWarning, source_.string() + ": " + warning);
    report_ = std::move(result->report);
    resolved_ = std::move(result->recipe);
    dependencies_ = std::move(result->dependencies);
    watchFiles();
  }
  while (std::optional<CookResult> result = comparer_.take()) {
    if (compared_.empty()) continue;
    if (result->asset)
      comparison_ = std::make_shared<Shown>(result->asset);
    else
      tell(Message::Kind::kError, result->error);
  }
}

void Session::watchFiles() {
  std::vector<fs::path> files = imagesOf(document.recipe());
  files.push_back(source_);
  if (!document.file().empty()) files.push_back(document.file());
  files.insert(files.end(), dependencies_.begin(), dependencies_.end());
  watch_.watch(files);
}

void Session::lookAtFiles() {
  for (const fs::path& file : watch_.changed()) {
    since_change_ = 0.0;
    const bool painted = document.content().images.contains(file);
    if ((file == document.file() || painted) && !isFile(file)) {
      document.overwrite(file);
      tell(Message::Kind::kWarning, file.string() + ": it was removed: save the recipe to have it back");
    } else if (file == document.file()) {
      if (document.dirty())
        conflict_ = true;
      else
        reload();
    } else if (painted) {
      // Painted here and saved: what another program makes of it is what counts from now on.
      if (document.dirty()) {
        conflict_ = true;
        continue;
      }
      Content content = document.content();
      content.images.erase(file);
      document.reloaded(std::move(content));
      reread_ = true;
    } else if (editable_) {
      reread_ = true;
    } else {
      request();
    }
  }
}

void Session::reload() {
  conflict_ = false;
  recipe_doubt_.clear();
  try {
    document.reloaded({pipeline::readRecipe(document.file()), {}});
    recipe_error_.clear();
    tell(Message::Kind::kNote, document.file().string() + ": changed on disk and read again");
  } catch (const pipeline::Error& error) {
    recipe_doubt_ = error.what();
  }
}

void Session::keep() {
  conflict_ = false;
  recipe_error_.clear();
  recipe_doubt_.clear();
  document.overwrite();
}

std::vector<Response> Session::responses(const Shown& of) const {
  std::vector<Response> responses;
  for (const Layer& layer : of.view().layers) {
    responses.push_back(layer.response);
    if (!editable_) continue;
    for (const pipeline::LayerRecipe& edited : document.recipe().layers)
      if (edited.name == layer.name && !edited.fit) responses.back() = edited.response;
  }
  return responses;
}

void Session::save(const fs::path& recipe) {
  if (!editable_) return;
  believe();
  // What somebody wrote there and mistyped is not replaced unasked.
  if (!recipe_error_.empty() && whole(recipe) == document.file()) {
    conflict_ = true;
    return;
  }
  try {
    document.save(whole(recipe));
    recipe_error_.clear();
    watchFiles();
    watch_.forget(document.file());
    for (const auto& [file, image] : document.content().images) watch_.forget(file);
    tell(Message::Kind::kNote, recipe.string() + ": saved");
  } catch (const pipeline::Error& error) {
    tell(Message::Kind::kError, error.what());
  }
}

void Session::cookTo(const fs::path& asset) {
  if (!editable_) return;
  std::vector<fs::path> inputs = imagesOf(document.recipe());
  inputs.insert(inputs.end(), dependencies_.begin(), dependencies_.end());
  inputs.insert(inputs.end(), {source_, document.file()});
  std::error_code ignored;
  if (std::any_of(inputs.begin(), inputs.end(), [&](const fs::path& input) {
        return whole(input) == whole(asset) || fs::equivalent(input, asset, ignored);
      })) {
    tell(Message::Kind::kError,
         asset.string() + ": the output would overwrite an input: choose another name");
    return;
  }
  worker_.request({source_, document.content(), number_, false, whole(asset)});
}

void Session::compareWith(const fs::path& file) {
  CookRequest request{source_, document.content(), ++number_, false, {}};
  try {
    if (preview::looksLikeAsset(file)) {
      request.source = whole(file);
    } else if (file.extension() == ".json") {
      request.content = {pipeline::readRecipe(file), {}};
    } else {
      request.source = whole(file);
      request.content = {pipeline::defaultRecipe(), {}};
    }
  } catch (const pipeline::Error& error) {
    tell(Message::Kind::kError, error.what());
    return;
  }
  compared_ = whole(file);
  comparer_.request(std::move(request));
}

void Session::endComparison() {
  compared_.clear();
  comparison_.reset();
}

}  // namespace furrow::editor
