#pragma once

// The tier that a command runs on.

#include <memory>
#include <string>

#include "editor/preview/headless_context.h"
#include "editor/preview/renderer.h"
#include "furrow/gl/tier.h"

namespace furrow::cli {

// Throws Error (kBadUsage) if FURROW_BACKEND is asked and is no tier.
void checkBackend(const std::string& backend);

class Backend {
 public:
  // `backend`: as --backend has it; "auto" also asks FURROW_BACKEND. choose() fails with kUnavailable for a
  // forced tier that is missing, require() throws Error (kEnvironment).
  explicit Backend(const std::string& backend) : backend_(backend) {}
  Status choose();
  void require();

  const gl::TierChoice& choice() const { return choice_; }
  void needContext();  // also on the cpu tier

  // What `frame`, a function of the tier, returns. Where it throws ContextLost, a tier that was not asked for
  // gives way to the next one; ContextLost goes on if it was, or if there is none left.
  template <typename Frame>
  auto run(const Frame& frame) {
    for (;;) try {
        return frame(choice_.tier);
      } catch (const preview::ContextLost& lost) {
        fall(lost);
      }
  }

  // Says on stderr where auto came to less than the gpu tier.
  void report() const;

 private:
  void fall(const preview::ContextLost& lost);

  std::string backend_;
  bool forced_ = false;
  std::unique_ptr<preview::HeadlessContext> context_;
  gl::TierChoice choice_;
};

}  // namespace furrow::cli
