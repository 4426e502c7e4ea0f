#pragma once
#include <functional>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::test {

/// Events in words, a line each: for messages of failed tests.
inline std::string words(const std::vector<Event>& events, const Catalogue& catalogue) {
  std::string text;
  for (const Event& event : events)
    if (const std::string line = to_text(event, catalogue); !line.empty()) text += line + "\n";
  return text;
}

/// Is it the outcome of a placement that held?
inline bool is_placed(const Event& event) {
  const auto* judged = std::get_if<PlacementJudged>(&event);
  return judged != nullptr && judged->record.outcome == PlacementRecord::Outcome::kPlaced;
}

}  // namespace stonestack::test
