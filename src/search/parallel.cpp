#include "search/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "stonestack/core/error.hpp"

namespace stonestack {

void run_tasks(int threads, std::size_t count, const std::function<void(std::size_t)>& task) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t k = range.begin(); k != range.end(); ++k) {
            throw_if_interrupted();
            task(k);
          }
        },
        tbb::simple_partitioner());
  });
}

}  // namespace stonestack
