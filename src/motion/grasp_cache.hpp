#pragma once
#include <cstddef>

namespace stonestack::motion {

/// Sets that `cached_grasps` keeps: four for each of eight stones (as it lies, denser, and from above in two
/// poses).
inline constexpr std::size_t kMaxGraspSets = 32;

}  // namespace stonestack::motion
