#pragma once
#include <unistd.h>

#include <fstream>

namespace stonestack::test {

/// Whether a sanitizer allocates: it keeps freed memory to find its use, so that resident memory says
/// nothing.
#ifdef STONESTACK_SANITIZED
inline constexpr bool kSanitizerAllocates = true;
#else
inline constexpr bool kSanitizerAllocates = false;
#endif

/// Resident memory of this process [MB], of /proc/self/statm.
inline double resident_megabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace stonestack::test
