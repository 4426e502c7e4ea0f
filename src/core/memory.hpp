#pragma once
#include <cstddef>

/// Private to the library: memory of the process.
namespace stonestack::core {

/// Returns freed heap memory to the operating system (glibc's malloc_trim; nothing elsewhere). Threads that
/// come and go leave arenas of freed blocks behind, which a process of many runs would otherwise hold.
void return_free_memory();

/// Heap memory that is in use [bytes]: without what was freed and not returned. 0 where that is not known.
[[nodiscard]] std::size_t heap_in_use();

}  // namespace stonestack::core
