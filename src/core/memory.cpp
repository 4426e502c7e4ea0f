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

}  // namespace stonestack::core
