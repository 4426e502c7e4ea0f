#pragma once
#include <string>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Writes a hand-eye calibration, camera in the flange, into a cell file and leaves every other character of
/// it as it is, comments included. `calibration` is the file that holds T_F_C, or empty.
///
///   the cell has layout.T_T_C     its numbers are replaced, by T_F_T of the cell
///   the cell has layout.hand_eye  it names `calibration`; without one T_T_C takes its place
///   the cell has neither          hand_eye is added, or T_T_C without `calibration`
///
/// The file is replaced as a whole, by its new text or not at all.
/// @return the line that was written: "layout.T_T_C: {x: ...}"
/// @throws FileError for a file that is no cell, and for one whose text cannot be edited (aliases, several
/// lines in one value): it says the line to write by hand.
std::string write_mount(const std::string& path, const Pose& T_F_C, const std::string& calibration = "");

/// A pose as a cell file has it, to 0.1 um: "{x: 0.0, y: 0.11, z: -0.17, qx: 0.0871557, ...}"
[[nodiscard]] std::string mount_text(const Pose& pose);

}  // namespace stonestack::hardware

#pragma GCC visibility pop
