#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// The text socket of Robotiq's URCap for 2-finger grippers and Hand-E (port 63352 of the robot's
/// controller), for both ends. A line "SET ACT 1 GTO 1" is answered by "ack", "GET POS" by "POS 120", what is
/// not understood by "?". Answers come with or without a line end (peers: ur_rtde, cambel/robotiq). A "GET
/// PRE" without a line end is answered by the value alone, "120" (peer: Robotiq's URScript). Parsers accept
/// any bytes.
namespace stonestack::protocol {

inline constexpr std::size_t kMaxGripperLine = 128;  ///< bytes of a line, either way

/// A variable and its value, 0 to 255.
using GripperVariable = std::pair<std::string, int>;

/// A line of a client: variables to set, or the one to get.
struct GripperLine {
  std::vector<GripperVariable> set;
  std::string get;
};
/// "SET ACT 1 GTO 1\n"
[[nodiscard]] std::string set_text(const std::vector<GripperVariable>& variables);
/// "GET POS\n"
[[nodiscard]] std::string get_text(const std::string& variable);
/// Parses a client's line, without its end; empty for what is none.
[[nodiscard]] std::optional<GripperLine> parse_gripper_line(std::string_view line);

/// True for "ack", with or without a line end.
[[nodiscard]] bool is_gripper_ack(std::string_view answer);
/// Value in the answer "POS 120" to `variable`; empty for any other text.
[[nodiscard]] std::optional<int> parse_gripper_answer(std::string_view answer, std::string_view variable);
/// True if these bytes may be the beginning of an answer or all of it: short, printable, one line.
[[nodiscard]] bool is_gripper_text(std::string_view answer);

}  // namespace stonestack::protocol
