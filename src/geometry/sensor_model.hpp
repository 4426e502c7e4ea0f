#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"

/// Private to the library: what is known of a kind of depth camera, one file each (data/sensors/*.yaml). The
/// simulator errs by it; who reads a depth image takes counts, lens and range from it.
namespace stonestack::geometry {

/// Errors of a depth camera. The file of each says where its numbers are from.
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
  double disparity_step = 0.0;    ///< disparities are multiples of it [px]; 0: as fine as the counts
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

/// A sensor by name ("d435": data/sensors/d435.yaml), or by the path of a file of that form. Every value of a
/// file has to be there. "ideal" has range and counts of an SR300 and no errors.
/// @throws FileError that names file, key, value and remedy.
[[nodiscard]] SensorModel read_sensor(const std::string& name_or_path);
/// Names in data/sensors, sorted, and "ideal".
[[nodiscard]] std::vector<std::string> sensor_names();

/// The nominal lens of a kind of sensor for images of that size; the share of the height that a narrower
/// format cuts off is taken from above and below.
[[nodiscard]] CameraIntrinsics nominal_lens(const SensorModel& sensor, int width, int height);

}  // namespace stonestack::geometry
