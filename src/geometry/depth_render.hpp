#pragma once
#include <memory>
#include <span>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// Hit of a ray.
struct RayHit {
  double distance = 0.0;   ///< distance [m] along the unit ray
  int instance = -1;       ///< index of `add`, in order
  int face = -1;           ///< of the instance's mesh
  Eigen::Vector3d normal;  ///< of the hit face, unit, towards the outside of its mesh, world frame
};

/// Rays against meshes at poses (Embree). Built once, then asked from any number of threads.
class RayScene {
 public:
  RayScene();
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// Adds a mesh at T_W_A; returns its instance index. Not after `commit`.
  int add(const Mesh& mesh_A, const Pose& T_W_A);
  /// Ends building.
  void commit();
  /// First hit of the ray; instance -1 if none. `direction` need not be unit length.
  [[nodiscard]] RayHit cast(const Eigen::Vector3d& p_W_from, const Eigen::Vector3d& direction_W) const;
  /// True if anything lies on the ray within `farthest` metres: cheaper than the first hit. `direction_W` is
  /// unit.
  [[nodiscard]] bool is_blocked(const Eigen::Vector3d& p_W_from, const Eigen::Vector3d& direction_W,
                                double farthest) const;
  /// How many rays from a point hit something within `farthest` metres: eight together, which is cheaper.
  /// `directions_W` are unit.
  [[nodiscard]] int count_blocked(const Eigen::Vector3d& p_W_from,
                                  std::span<const Eigen::Vector3d> directions_W, double farthest) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

/// A noise-free view: depth, and per pixel the instance (-1: nothing) and surface normal in W.
struct RenderedView {
  DepthImage depth;
  std::vector<int> instance;
  std::vector<Eigen::Vector3f> normal_W;
};
[[nodiscard]] RenderedView render(const RayScene& scene, const CameraIntrinsics& camera, const Pose& T_W_C);

}  // namespace stonestack::geometry
