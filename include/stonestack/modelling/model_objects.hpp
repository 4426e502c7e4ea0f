#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/detection/segment.hpp"
#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::modelling {

/// How views become models of objects that nobody scanned.
struct ModellingOptions {
  double voxel = 0.0015;      ///< edge of a cell of the distance volume [m]
  double truncation = 0.006;  ///< distance from a seen surface up to which a view says how far it is [m]
  double facet = 0.004;       ///< largest radius of a triangle's circumcircle [m]
  SegmentOptions segment;     ///< how objects are parted
  bool refine_poses = true;   ///< views are aligned with each other; false: their poses are exact
};
/// Without those of `segment`.
[[nodiscard]] FieldList fields(ModellingOptions& options);

/// Views of objects that lie still on a table, brought to agree, and the objects in them.
struct AlignedScene {
  /// With poses that agree, without the depth error that they share; the table is z = 0 of W.
  std::vector<DepthView> views;
  Segmentation segmentation;  ///< of these views: objects, and a label image each
  double apart_before = 0.0;  ///< median distance of surfaces that two views show, as reported [m]
  double apart_after = 0.0;   ///< the same with the poses that agree [m]
};

/// Takes the smooth depth error that all views share off them, as the table shows it, then brings them to
/// agree by the surfaces that they share (point to plane over all pairs of views, projective association;
/// Chen and Medioni 1992), as far from the reported poses as arms and hand-eye calibrations err, puts the
/// table at z = 0, and parts the objects.
/// @throws InvalidArgument for no view, an image that lacks depths, and lengths that are not above 0.
[[nodiscard]] AlignedScene align_scene(std::span<const DepthView> views,
                                       const ModellingOptions& options = {});

/// An object as it lies in a scene.
struct LyingObject {
  const AlignedScene* scene = nullptr;  ///< required
  int object = 0;                       ///< index into scene->segmentation.objects
  Pose T_W_O = Pose::Identity();        ///< frame of the model that is to be made
};

/// Closed surface of an object, and how well each place of it is known.
struct ObjectModel {
  Mesh mesh;                  ///< closed, in O [m]
  std::vector<double> sigma;  ///< a vertex each: standard deviation of its distance from the surface [m]
  std::vector<char> seen;     ///< a vertex each: 1 where a view showed it, 0 where it was completed
  double seen_share = 0.0;    ///< of the area that was seen
  int views = 0;              ///< that show it
};

/// Fuses what all views show of one object into a truncated signed distance (Curless and Levoy 1996). What no
/// view shows is completed: it lies behind what was seen through and above every table that the object lay
/// on, and between these the distance is the smoothest one (Laplace's equation), so that an unseen underside
/// ends at the table. Closed by construction.
/// @return empty for an object that is too large for its cells (64 million), and where the views see through
/// all of it, as they do where they are joined wrongly; the log says which
/// @throws InvalidArgument for no object, one that no view shows, and lengths that are not above 0.
[[nodiscard]] std::optional<ObjectModel> model_object(std::span<const LyingObject> lying,
                                                      const ModellingOptions& options = {});

/// Where an object lies that was modelled before.
struct FoundObject {
  Pose T_W_O = Pose::Identity();  ///< pose of the model
  double agreement =
      0.0;             ///< share of what is seen of it that lies within 2 mm of the seen part of the model
  double apart = 0.0;  ///< median distance of that part [m]
  /// Places of the model's seen part that views confirm, times the share that they do not refute: the larger
  /// the likelier, of one model.
  double confirmed = 0.0;
};
/// Finds how an object lies that was turned since it was modelled, by the surface that both show (iterated
/// closest points): from several starts near where it was meant to lie, and if none agrees, as it may have
/// toppled, from many all around. A pose is refuted where a view sees through what was seen of the model, or
/// it lies in the table, and where views of which the model was made see through what is seen now.
/// @param made_of what the model was made of; may be empty
/// @return empty where they share too little.
[[nodiscard]] std::optional<FoundObject> find_turned(const ObjectModel& model,
                                                     std::span<const LyingObject> made_of,
                                                     const LyingObject& as_meant);

/// Every object of one scene as a model in W: what one set of views tells. An object each, empty as
/// `model_object` is.
[[nodiscard]] std::vector<std::optional<ObjectModel>> model_objects(const AlignedScene& scene,
                                                                    const ModellingOptions& options = {});

}  // namespace stonestack::modelling

#pragma GCC visibility pop
