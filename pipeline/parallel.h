#pragma once

// Loops that several threads share.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace furrow::pipeline {

// run(i) for every i below `count`, on up to `threads` threads, this one among them, or as many as the system
// gives. Of the exceptions that are thrown, that of the lowest i is passed on.
template <class Run>
void parallelFor(uint32_t count, uint32_t threads, const Run& run) {
  std::atomic<uint32_t> next = 0;
  std::mutex mutex;
  std::exception_ptr error;
  uint32_t failed = count;
  const auto work = [&] {
    for (uint32_t i = next++; i < count; i = next++) {
      try {
        run(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i < failed) {
          failed = i;
          error = std::current_exception();
        }
      }
    }
  };
  {
    std::vector<std::jthread> others;
    try {
      for (uint32_t i = 1; i < std::min(threads, count); ++i) others.emplace_back(work);
    } catch (const std::system_error&) {
    }
    work();
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

// run(begin, end) for ranges that make up [0, count), large enough to be worth a thread.
template <class Run>
void parallelRanges(size_t count, uint32_t threads, const Run& run) {
  constexpr size_t kRange = 4096;
  parallelFor(static_cast<uint32_t>((count + kRange - 1) / kRange), threads,
              [&](uint32_t i) { run(i * kRange, std::min(count, (i + 1) * kRange)); });
}

}  // namespace furrow::pipeline
