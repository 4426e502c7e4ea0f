#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "protocol/ur_version.hpp"

/// Lines of the Dashboard server of a UR controller (port 29999).
namespace stonestack::protocol {

/// "URSoftware 3.15.8.106339 (Nov 05 2021)" and the like; empty for anything else.
[[nodiscard]] std::optional<UrVersion> parse_polyscope_version(std::string_view line);
/// Value that follows `label` in a reply, "RUNNING" of "Robotmode: RUNNING"; empty if the line does not begin
/// so.
[[nodiscard]] std::optional<std::string> dashboard_value(std::string_view line, std::string_view label);
/// "true" and "false", in either case of letters; empty for anything else.
[[nodiscard]] std::optional<bool> dashboard_truth(std::string_view text);
/// True for printable ASCII of at most 1 KiB, which is all that a Dashboard sends.
[[nodiscard]] bool is_dashboard_text(std::string_view line);

}  // namespace stonestack::protocol
