// Loops that several threads share.

#include "pipeline/parallel.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <numeric>
#include <stdexcept>

namespace furrow::pipeline {
namespace {

void expectAll(uint32_t threads) {
  std::vector<uint32_t> done(1000);
  parallelFor(1000, threads, [&](uint32_t i) { done[i] += i; });
  std::vector<uint32_t> expected(1000);
  std::iota(expected.begin(), expected.end(), 0u);
  EXPECT_EQ(done, expected) << threads << " threads";
}

TEST(Parallel, DoesEverythingOnceOnAnyNumberOfThreads) {
  for (const uint32_t threads : {0u, 1u, 2u, 64u}) expectAll(threads);
}

TEST(Parallel, ThrowsWhatTheLowestThrew) {
  try {
    parallelFor(100, 4, [](uint32_t i) {
      if (i >= 40) throw std::runtime_error(std::to_string(i));
    });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "40");
  }
}

#ifdef __GLIBC__
// As in a container with few of them.
TEST(Parallel, GoesOnWhereTheSystemGivesNoThread) {
  pthread_attr_t usual, huge;
  ASSERT_EQ(pthread_getattr_default_np(&usual), 0);
  ASSERT_EQ(pthread_attr_init(&huge), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&huge, size_t{1} << 48), 0);  // more than there are addresses
  ASSERT_EQ(pthread_setattr_default_np(&huge), 0);
  EXPECT_THROW(std::thread([] {}).join(), std::system_error);
  expectAll(4);
  pthread_setattr_default_np(&usual);
  expectAll(4);
}
#endif

}  // namespace
}  // namespace furrow::pipeline
