#pragma once
#include <string>

#include "emulators/ur/controller.hpp"

/// State messages of ports 30001 to 30003. Sources: UR's "Remote Control Via TCP/IP" tables and the parsers of its
/// client library; sizes of the sub-packages as a robot with PolyScope 5.8 sends them.
namespace stonestack::emulators {

/// First message to every primary and secondary client.
[[nodiscard]] std::string encode_version_message(const UrController& controller);
/// One ROBOT_MESSAGE.
[[nodiscard]] std::string encode_event(const UrController& controller, const ControllerEvent& event);
/// ROBOT_STATE with its sub-packages.
[[nodiscard]] std::string encode_robot_state(const UrController& controller);
/// One package of the realtime port: 1060 bytes up to 3.4, 1108 from 3.5 and 5.0, 1116 from 3.10 and 5.4,
/// 1140 from 3.14 and 5.9, 1220 from 3.15 and 5.10.
[[nodiscard]] std::string encode_realtime(const UrController& controller);

/// C210: a script came in on a port that takes none.
[[nodiscard]] ControllerEvent read_only_error();

}  // namespace stonestack::emulators
