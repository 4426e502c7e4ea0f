#include "core/memory.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "resident_memory.hpp"

namespace stonestack::core {
namespace {

/// Every tenth block stays, so that the heap of each thread is full of holes.
std::vector<std::unique_ptr<char[]>> leave_holes() {
  std::vector<std::unique_ptr<char[]>> kept;
  std::vector<std::unique_ptr<char[]>> freed;
  for (int k = 0; k < 2000; ++k) {
    auto block = std::make_unique<char[]>(10000);
    for (int i = 0; i < 10000; i += 1000) block[static_cast<std::size_t>(i)] = 1;
    (k % 10 == 0 ? kept : freed).push_back(std::move(block));
  }
  return kept;
}

TEST(Memory, ReturnsWhatThreadsHaveFreed) {
  std::vector<std::vector<std::unique_ptr<char[]>>> kept(4);
  std::vector<std::thread> threads;
  for (auto& blocks : kept) threads.emplace_back([&blocks] { blocks = leave_holes(); });
  for (std::thread& thread : threads) thread.join();
  const double before = test::resident_megabytes();
  return_free_memory();
  if (test::kSanitizerAllocates) GTEST_SKIP() << "a sanitizer keeps what is freed";
  EXPECT_LT(test::resident_megabytes(), before - 30.0) << "72 MB were freed";
}

TEST(Memory, CountsWhatEachThreadHasInUse) {
  if (test::kSanitizerAllocates) GTEST_SKIP() << "a sanitizer has a heap of its own";
  const std::size_t before = heap_in_use();
  std::vector<std::unique_ptr<char[]>> kept;
  std::thread([&kept] { kept = leave_holes(); }).join();
  const auto more = static_cast<double>(heap_in_use() - before);
  EXPECT_NEAR(more, 200 * 10000, 100000) << "not the 1,800 blocks that were freed";
}

}  // namespace
}  // namespace stonestack::core
