#pragma once
#include <unistd.h>

#include <fstream>

namespace stonestack::test {

/// Resident memory of this process [MB], of /proc/self/statm.
inline double resident_megabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace stonestack::test
