#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::geometry {

/// One recorded depth image: where it is and what is known of it.
struct DepthRecord {
  std::string path;   ///< 16-bit PNG
  int number = 0;     ///< in the recording (BOP: the image's number)
  double time = 0.0;  ///< as recorded [s]; 0 if the layout has none
  double unit = 0.0;  ///< metres per count
  CameraIntrinsics camera;
  std::optional<Pose> T_W_C;
};

/// A folder of depth images, in one of the usual layouts.
struct DepthSequence {
  std::string layout;  ///< bop, open3d, tum
  std::vector<DepthRecord> records;
};

/// Camera data that a recording leaves out. Nothing is guessed: TUM has neither intrinsics nor a depth scale
/// in its files, Open3D often no scale.
struct DepthSequenceInput {
  double unit = 0.0;                       ///< metres per count; 0: it must stand in the files
  std::optional<CameraIntrinsics> camera;  ///< replaces the files' intrinsics
};

/// Reads what a folder holds:
///
///   BOP     scene_camera.json (cam_K, depth_scale in mm a count, cam_R_w2c and cam_t_w2c)
///           and depth/NNNNNN.png; what `BopFolder` adds to an image (time, distortion, k)
///   Open3D  camera_intrinsic.json (width, height, intrinsic_matrix by columns, depth_scale
///           in counts a metre) and depth/*.png
///   TUM     depth.txt (time, file) and groundtruth.txt (time, T_W_C), matched within 20 ms
///
/// Images are not opened but for their size. Throws FileError naming file, key and value, also when unit or
/// intrinsics are missing, or given twice and different (a depth scale off by 5 or 1000 is the usual
/// mistake), or when the intrinsics are of images of another size or Open3D's matrix stands by rows.
[[nodiscard]] DepthSequence read_depth_sequence(const std::string& folder,
                                                const DepthSequenceInput& input = {});

/// True if the folder has one of these layouts.
[[nodiscard]] bool is_depth_sequence(const std::string& folder);

/// Width and height of a PNG file.
/// @throws FileError
[[nodiscard]] Eigen::Vector2i png_size(const std::string& path);

/// Throws FileError naming `path` when the principal point lies further outside the image than half its size:
/// intrinsics of another image, or in another order.
void check_principal_point(const CameraIntrinsics& camera, const std::string& path);

/// Opens one image.
[[nodiscard]] DepthImage read_depth(const DepthRecord& record);

}  // namespace stonestack::geometry
