#include "program.hpp"

#include <gtest/gtest.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <latch>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "resident_memory.hpp"

namespace stonestack::apps {
namespace {

#ifdef __GLIBC__
/// Heaps that malloc has opened, each with what is free in it.
std::size_t heaps_open() {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* file = open_memstream(&text, &size);
  malloc_info(0, file);
  std::fclose(file);
  const std::string info(text, size);
  std::free(text);
  std::size_t count = 0;
  for (auto at = info.find("<heap nr="); at != std::string::npos; at = info.find("<heap nr=", at + 1))
    ++count;
  return count;
}

/// Allocates in `count` threads that all live at once.
void allocate_in_threads(std::size_t count) {
  std::latch all_allocated(static_cast<std::ptrdiff_t>(count));
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < count; ++k)
    threads.emplace_back([&all_allocated] {
      const auto block = std::make_unique<char[]>(10000);
      all_allocated.arrive_and_wait();
    });
  for (std::thread& thread : threads) thread.join();
}

TEST(Program, OpensNoHeapForEachOfManyThreads) {
  if (test::kSanitizerAllocates) GTEST_SKIP() << "a sanitizer has a heap of its own";
  ::unsetenv("MALLOC_ARENA_MAX");
  const std::size_t processors = std::max(2u, std::thread::hardware_concurrency());
  std::string name = "program", command = "threads";
  char* arguments[] = {name.data(), command.data(), nullptr};
  const int code = run_program(2, arguments, [&](CLI::App& app) {
    app.add_subcommand("threads")->callback([&] { allocate_in_threads(4 * processors); });
  });
  EXPECT_EQ(code, 0);
  EXPECT_LE(heaps_open(), processors);
}
#endif

}  // namespace
}  // namespace stonestack::apps
