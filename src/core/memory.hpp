#pragma once

/// Private to the library: memory of the process.
namespace stonestack::core {

/// Returns freed heap memory to the operating system (glibc's malloc_trim; nothing elsewhere). Threads that
/// come and go leave arenas of freed blocks behind, which a process of many runs would otherwise hold.
void return_free_memory();

}  // namespace stonestack::core
