#include "search/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "stonestack/core/error.hpp"

namespace stonestack::search {

void run_tasks(int threads, std::size_t count, const std::function<void(std::size_t)>& task) {
  using tbb::global_control;
  // More threads than cores are allowed when asked for (the default limit would print a warning).
  const auto allowed = std::max(static_cast<std::size_t>(std::max(threads, 0)),
                                global_control::active_value(global_control::max_allowed_parallelism));
  const global_control limit(global_control::max_allowed_parallelism, allowed);
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

}  // namespace stonestack::search
