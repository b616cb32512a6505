#include "editor/cli/backend.h"

#include <cstdio>
#include <string_view>

#include "pipeline/error.h"

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;

std::string_view wantedTier(const std::string& backend) {
  std::string_view wanted;
  if (const Status status = gl::wantedTier(backend, wanted); !status.ok())
    throw Error(Exit::kBadUsage, "environment", status.message, "set it to one of these, or not at all");
  return wanted;
}

}  // namespace

void checkBackend(const std::string& backend) {
  wantedTier(backend);
}

Status Backend::choose() {
  const std::string_view wanted = wantedTier(backend_);
  forced_ = wanted != "auto";
  std::string no_context;
  try {
    if (wanted != "cpu") needContext();
  } catch (const Error& error) {
    no_context = error.what();
    no_context.resize(no_context.rfind(": "));  // what to do is another here
  }
  return gl::chooseTier(wanted, no_context, choice_);
}

void Backend::require() {
  if (const Status status = choose(); !status.ok())
    throw Error(Exit::kEnvironment, "--backend " + std::string(wantedTier(backend_)), status.message,
                "use auto");
}

void Backend::needContext() {
  if (!context_) context_ = std::make_unique<preview::HeadlessContext>();
}

void Backend::fall(const preview::ContextLost& lost) {
  if (forced_ || choice_.tier == gl::Tier::kCpu) throw lost;
  context_.reset();
  choice_.tier = gl::nextTier(lost.tier());
  try {
    if (choice_.tier != gl::Tier::kCpu) needContext();
  } catch (const Error&) {
    choice_.tier = gl::Tier::kCpu;
  }
  std::snprintf(choice_.reason, sizeof choice_.reason, "%s: the %s tier ended: %s",
                gl::tierName(choice_.tier), gl::tierName(lost.tier()), lost.how().c_str());
}

void Backend::report() const {
  if (backend_ == "auto" && choice_.tier != gl::Tier::kGpu)
    std::fprintf(stderr, "furrow: using the tier %s\n", choice_.reason);
}

}  // namespace furrow::cli
