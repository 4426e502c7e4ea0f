#pragma once
#include "search/contact_search.hpp"

namespace stonestack::search {

/// Result of a descent.
struct Descent {
  ContactSearch best;
  std::vector<ContactSearch> tried;  ///< every evaluation, in order
};

/// Contact pose refinement (paper §3.2): the pose is perturbed by a small step in each of five directions
/// (sideways in x and y, turned about x, y and z; the attraction sets the sixth), the gradient of eq. (2)
/// follows by finite differences, and the pose descends until the cost converges. Each evaluation is a
/// contact search of its own from just above the displaced pose.
[[nodiscard]] Descent descend(const SearchContext& context, const Target& target, StoneIndex stone,
                              ContactSearch start);

}  // namespace stonestack::search
