#include "stacking/unstack_depth.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kCost = 0.2;  // stones, of each stone that is unstacked; design choice

}  // namespace

std::size_t unstack_depth(const std::vector<double>& expected, std::size_t standing) {
  std::size_t depth = 0;
  auto best = static_cast<double>(standing);
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const double worth = expected[k] - kCost * static_cast<double>(k + 1);
    if (worth <= best) continue;
    best = worth;
    depth = k + 1;
  }
  return depth;
}

}  // namespace stonestack::stacking
