#pragma once

/// Constants of modelling/. Lengths in metres.
namespace stonestack::modelling {

inline constexpr double kMaxDepthStep = 0.004;  // between neighbouring pixels of one surface
inline constexpr double kMinCosine = 0.20;      // of a view on a surface: flatter ones say little
inline constexpr double kMargin = 0.025;        // of a volume around what is seen of an object
inline constexpr double kPoseSigma = 0.0005;    // of the poses of aligned views, all told

}  // namespace stonestack::modelling
