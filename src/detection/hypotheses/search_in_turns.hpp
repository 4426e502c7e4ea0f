#pragma once
#include <vector>

#include "detection/hypotheses/candidates.hpp"
#include "detection/trace.hpp"

namespace stonestack::detection {

/// Searches the unexplained points repeatedly for the missing stones: the cheap sweep first,
/// which finds stones that stand alone, then descriptors on the rest, then all orientations on what is left,
/// also between creases; and again from the start when a turn has found something. At last, one pose that
/// was nearly accepted is taken for granted, to see whether the obstruction is a missing stone.
/// `missing` names a model as often as it may be there. Fills `trace` if given.
[[nodiscard]] std::vector<Candidate> search_in_turns(const DetectionModels::Data& data,
                                                     std::vector<StoneIndex> missing, DetectionScene scene,
                                                     const DetectionOptions& options, DetectionTrace* trace);

}  // namespace stonestack::detection
