#pragma once
#include <span>
#include <string>
#include <vector>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// How far one thing that moves stays away from one that stands, instead of what motions keep from all
/// others.
struct PairPadding {
  std::string a;   ///< arm, hand, held, or a link: shoulder, upper arm, forearm, wrist 1, wrist 2, wrist 3
  std::string b;   ///< table, or an obstacle's name
  double m = 0.0;  ///< [m]
};

/// Reads a YAML list of them:
///
///   - {a: hand, b: table, m: 0.004}
///   - {a: arm, b: wall, m: 0.05}
///
/// `obstacles`: names that may stand for `b`. `where` names the list in messages. An empty text is an empty
/// list. Throws FileError with file, key and value, also for a name that nothing has.
[[nodiscard]] std::vector<PairPadding> parse_pair_paddings(const std::string& text, const std::string& path,
                                                           const std::string& where,
                                                           std::span<const std::string> obstacles);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
