#pragma once

/// Constants of modelling/. Lengths in metres.
namespace stonestack::modelling {

inline constexpr double kMaxDepthStep = 0.004;  // between neighbouring pixels of one surface
inline constexpr double kMinCosine = 0.20;      // of a view on a surface: flatter ones say little
// Of seen surface, all views alike, so that none shows it: what is left of the camera's smooth error and of
// the poses. Fitted (bench modelling, cell lab).
inline constexpr double kSharedSigma = 0.00045;
inline constexpr double kMargin = 0.025;  // of a volume around what is seen of an object

}  // namespace stonestack::modelling
