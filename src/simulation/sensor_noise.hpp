#pragma once
#include <cstdint>
#include <string>

#include "geometry/depth_render.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {

/// Errors of a depth camera. SR300 and D435 are assumptions (SR300: 0.4 mm + 1 mm z^2, z in m), the F200 is
/// fitted to recordings; every number is a field so that it can be.
struct SensorModel {
  std::string name = "ideal";
  CameraIntrinsics camera;        ///< as the device reports it
  CameraIntrinsics lens;          ///< as it is
  double unit = 0.000125;         ///< metres per count of the depth image
  double nearest = 0.2;           ///< [m]
  double farthest = 1.5;          ///< [m]
  double sigma = 0.0;             ///< standard deviation of depth at z = 0 ... [m]
  double sigma_square = 0.0;      ///< ... plus this times z^2 [1/m]
  double stereo_subpixel = 0.0;   ///< RMS disparity [px]; adds z^2 * this / (fx * stereo_baseline)
  double stereo_baseline = 0.05;  ///< [m]
  double correlation = 0.0;       ///< standard deviation of the Gaussian that correlates neighbours [px]
  double grazing = 0.0;           ///< factor 1 + grazing * theta^2 / (pi/2 - theta)^2 (Nguyen et al. 2012)
  double min_cosine = 0.0;        ///< no return from a surface seen at a smaller cosine
  double bias = 0.0;              ///< standard deviation of a smooth error that stays from frame to frame [m]
  double bias_pixels = 32.0;      ///< its wave length [px]
  std::uint64_t bias_seed = 1;    ///< one device, one bias
  double edge_step = 0.015;       ///< depth range around a pixel from which on it is at an edge [m]
  int edge_reach = 1;             ///< pixels each way in which that range is taken
  double edge_jitter = 0.0;       ///< standard deviation, sideways, at edges [px]
  double edge_flying = 0.0;       ///< share of edge pixels that float between front and back
  double edge_holes = 0.0;        ///< share of edge pixels without a return
  double shadow_baseline = 0.0;   ///< to the projector or second eye, along +x of C [m]; 0: no shadow
  double hole_share = 0.0;        ///< of all pixels
  int blobs = 0;                  ///< patches without a return, a frame
  double blob_radius = 6.0;       ///< mean [px]
};

/// Coded light at 640 x 480: 0.2 to 1.5 m, 1/8 mm counts, 0.4 mm + 1.0 mm/m^2 z^2.
[[nodiscard]] SensorModel make_sr300();
/// Active stereo: baseline 50 mm, 0.08 px, noise correlated over a few pixels, 1 mm counts.
[[nodiscard]] SensorModel make_d435();
/// Coded light as recorded with a RealSense F200, the SR300's predecessor (docs/measurements.md, Depth
/// camera): 0.2 mm + 0.43 mm/m^2 z^2 of noise, 0.8 mm of smooth error, edges smeared over several pixels.
[[nodiscard]] SensorModel make_f200();
/// By name: "sr300", "d435", "f200", "ideal" (range and counts only). Throws InvalidArgument.
[[nodiscard]] SensorModel make_sensor(const std::string& name);

/// The image that the sensor reports of a perfect view taken from T_W_C. Order of effects: no return at
/// grazing angles, shadow, edges (jitter, flying pixels, holes), bias, noise, holes and blobs, range, counts.
[[nodiscard]] DepthImage add_noise(const RenderedView& view, const Pose& T_W_C, const SensorModel& model,
                                   Random& random);

}  // namespace stonestack::simulation
