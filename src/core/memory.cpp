#include "core/memory.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace stonestack::core {

void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::size_t heap_in_use() {
#ifdef __GLIBC__
  const struct mallinfo2 heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
#else
  return 0;
#endif
}

}  // namespace stonestack::core
