#pragma once
#include <compare>
#include <cstdint>
#include <string>

#include "stonestack/core/rooms.hpp"

namespace stonestack::protocol {

/// Version of a UR controller as it answers RTDE 'v' or Dashboard `PolyscopeVersion`. Major 3 is CB3,
/// 5 e-Series, 10 PolyScope X.
struct UrVersion {
  std::uint32_t major = 0, minor = 0, bugfix = 0, build = 0;
  friend auto operator<=>(const UrVersion&, const UrVersion&) = default;
  [[nodiscard]] bool is_cb3() const { return major < 5; }
  /// Control rate in Hz, which is also the fastest RTDE rate: 125 on CB3, 500 since.
  [[nodiscard]] double control_rate() const { return is_cb3() ? 125.0 : 500.0; }
  /// True if this version has what came with `cb3` on a CB3 and with `e_series` on an e-Series. A zero
  /// version on either side means "never came there".
  [[nodiscard]] bool has(const UrVersion& cb3, const UrVersion& e_series) const {
    const UrVersion& first = is_cb3() ? cb3 : e_series;
    return first.major > 0 && *this >= first;
  }
};

/// "3.15.8.106339".
[[nodiscard]] std::string to_string(const UrVersion& version);

}  // namespace stonestack::protocol
