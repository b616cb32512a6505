#pragma once

// Tests that draw: they skip visibly where the machine has no OpenGL context.

#include <gtest/gtest.h>

#include <memory>

#include "editor/preview/headless_context.h"
#include "furrow/gl/tier.h"
#include "pipeline/error.h"

namespace furrow::tests {

class GlTest : public testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<preview::HeadlessContext>();
    } catch (const pipeline::Error& error) {
      GTEST_SKIP() << error.what();
    }
    support_ = gl::querySupport();
  }

  void closeContext() { context_.reset(); }

  gl::Support support_;

 private:
  std::unique_ptr<preview::HeadlessContext> context_;
};

}  // namespace furrow::tests
