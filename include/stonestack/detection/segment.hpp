#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/geometry/cloud.hpp"

#pragma GCC visibility push(default)

namespace stonestack::detection {

/// Limits of segmentation.
struct SegmentOptions {
  double nearest = 0.15;     ///< depth range that is looked at [m]
  double farthest = 2.0;     ///< [m]
  double min_width = 0.02;   ///< of an object's seen surface, square root of its area across the view [m]
  double usual_size = 0.40;  ///< longest extent up to which an object is as expected [m]
  int seed = 1;              ///< seed of the search for the table
};

/// An object that nobody knew, as far as it was seen.
struct SegmentedObject {
  Cloud cloud_C;  ///< seen surface with normals towards the camera, not organised, in C
  Eigen::Vector3d p_C_middle = Eigen::Vector3d::Zero();  ///< mean of the seen surface [m]
  /// Extents of the seen surface: longest and shortest along the table, and from the table up [m].
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  int pixels = 0;           ///< of all views
  int views = 0;            ///< that show it
  double confidence = 0.0;  ///< estimated probability that it is one whole object as far as it is seen
  bool cut_off = false;     ///< reaches the border of an image, so that a part of it is out of view
};

/// Objects on a table in one view or in several of one scene. C is the camera of the first.
struct Segmentation {
  std::vector<SegmentedObject> objects;  ///< the one with most pixels first
  /// A view each, row by row: 1 + index into `objects`; 0 where there is none.
  std::vector<std::vector<int>> labels;
  std::optional<Plane> table_C;  ///< normal towards the camera
  std::string note;              ///< why there is no object, or what is odd, for a person; empty otherwise
};

/// Parts the unknown objects that stand on the table, also those that touch or lie on each other, by the
/// grooves between them (watershed and hierarchical merging), and joins what an object in front divides and
/// the inside of a vessel with its outside. Depth alone decides. Never throws for what a camera may show: an
/// image without a table or with nothing on it gives no objects and a note.
[[nodiscard]] Segmentation segment(const DepthImage& image, const SegmentOptions& options = {});

/// Segments several views of one scene: each alone, then parts that show the same surface are joined, unless
/// a view shows them apart. A view that shows no table is passed over with a note; one whose image lacks
/// depths ends it with a note.
/// @throws InvalidArgument for no view.
[[nodiscard]] Segmentation segment(std::span<const DepthView> views, const SegmentOptions& options = {});

}  // namespace stonestack::detection

#pragma GCC visibility pop
