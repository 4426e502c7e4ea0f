#pragma once
#include <cstddef>
#include <functional>

#include "stonestack/core/rooms.hpp"

namespace stonestack::search {

/// Runs task 0 .. count-1 on `threads` threads (0: all cores). Tasks write to slots of their own, so results
/// do not depend on the number of threads. The first exception is rethrown; Ctrl-C ends it as Interrupted.
void run_tasks(int threads, std::size_t count, const std::function<void(std::size_t)>& task);

}  // namespace stonestack::search
