#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"

/// Private to modelling/: truncated signed distances on a grid.
namespace stonestack::modelling {
using namespace geometry;

/// A view, prepared for fusion with one object.
struct FusedView {
  const DepthImage* depth = nullptr;  ///< as the camera gave it
  const std::vector<Eigen::Vector3f>* normal_C =
      nullptr;                 ///< a pixel each, towards the camera; zero: unknown
  std::vector<char> shows;     ///< a pixel each: it shows the object
  std::vector<float> seen_to;  ///< a pixel each: depth up to which all around it is free [m]
  Pose T_C_O = Pose::Identity();
};

/// Grid over a box in O. Negative inside the object.
class DistanceVolume {
 public:
  /// Does a grid over the box have at most 64 million cells?
  [[nodiscard]] static bool fits(const Eigen::AlignedBox3d& box_O, double cell);
  /// Throws InvalidArgument unless it fits.
  DistanceVolume(const Eigen::AlignedBox3d& box_O, double cell, double truncation);

  /// Adds what views show, and planes (T_W_O each) below whose z = 0 there is nothing.
  void fuse(const std::vector<FusedView>& views, const std::vector<Pose>& T_W_O);
  /// Gives a distance to every node that no view gave one, by Laplace's equation from coarse to fine.
  void complete();

  /// Trilinear, clamped to the truncation; the truncation outside of the box [m].
  [[nodiscard]] double distance(const Eigen::Vector3d& p_O) const;
  /// Weight of the views at the nearest node: 1 is one view straight on it at 0.5 m.
  [[nodiscard]] double weight(const Eigen::Vector3d& p_O) const;
  /// Number of equal views that err as little in the mean as those that show the surface at the nearest node:
  /// (sum w)^2 / sum w^2 of their weights; 0 where none does.
  [[nodiscard]] double effective_views(const Eigen::Vector3d& p_O) const;
  /// Standard deviation of a single view's distances, from how views that show the same surface differ: noise
  /// of the pixels, errors of the poses, and smooth errors that a view has alone [m]; empty where hardly any
  /// surface is shown by two views.
  [[nodiscard]] std::optional<double> spread() const;
  [[nodiscard]] const Eigen::AlignedBox3d& box() const { return box_; }
  /// A point deep inside the object, from where `distance` grows in all directions.
  [[nodiscard]] Eigen::Vector3d deepest() const;
  /// Removes all but the largest connected part inside.
  void keep_largest_part();

 private:
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_.y()) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] Eigen::Vector3d node(int i, int j, int k) const {
    return box_.min() + cell_ * Eigen::Vector3d(i, j, k);
  }
  [[nodiscard]] std::optional<std::size_t> nearest_node(const Eigen::Vector3d& p_O) const;
  void solve(int stride, int rounds);

  Eigen::AlignedBox3d box_;
  double cell_, truncation_;
  Eigen::Vector3i size_;
  std::vector<float> distance_;
  std::vector<float> weight_;
  std::vector<float> effective_views_;
  double squares_ = 0.0;     ///< of the views' distances from their mean, at all nodes near the surface [m^2]
  double terms_ = 0.0;       ///< degrees of freedom of `squares_`
  std::vector<char> fixed_;  ///< the distance is measured, not completed
};

}  // namespace stonestack::modelling
