#pragma once
#include "stacking/workcell.hpp"

/// Private to stacking/: does the camera still sit where the layout has it?
namespace stonestack::stacking {

/// Checks the camera where the stone that was just placed seems to have slid without turning: so does what a
/// camera shows that was pushed aside in its mount. A view with the camera turned shows a stone that slid in
/// the same place, and one that did not slid to the other side. Nothing is checked where no such view can be
/// reached, or does not show the stone.
/// @throws DeviceError for a camera that has moved.
void check_camera_kept(Workcell& workcell, const Expectation& expected, const WorldEstimate& seen,
                       const CameraView& of_site);

}  // namespace stonestack::stacking
