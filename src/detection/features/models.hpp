#pragma once
#include <string>
#include <vector>

#include "detection/features/made_once.hpp"
#include "detection/features/surface_field.hpp"
#include "detection/features/surface_sigma.hpp"
#include "detection/scene/preprocess.hpp"
#include "geometry/surface_tree.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::detection {

/// Descriptors of keypoints: one row each, and where they are.
struct Features {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  Eigen::MatrixXf descriptors;  ///< row a keypoint; only finite ones are kept
};

/// How much of a stone shows from one side, for the orientation sweep.
struct ModelSide {
  Eigen::Vector3f towards;  ///< unit, from the stone to the camera, in O
  Eigen::Vector3f centre;   ///< mean of what shows, weighted as pixels weigh it, in O
  float area = 0.0F;        ///< projected [m^2]
};

/// A sample of a model's surface, in O: all of it in one cache line, as registrations read them in no order.
struct alignas(32) ModelSample {
  Eigen::Vector3f p;
  float sigma = 0.0F;  ///< standard deviation of the surface there [m]
  Eigen::Vector3f n;   ///< unit, outwards
};

/// A stone prepared for detection, in O.
struct DetectionModel {
  std::string name;
  Mesh mesh;
  Mesh drawn;                                  ///< of few faces, to be drawn into images
  std::vector<Eigen::Vector3d> drawn_normals;  ///< of its faces
  double area = 0.0;                           ///< of the whole surface [m^2]
  Eigen::Vector3d centre;                      ///< of the bounding sphere
  double radius = 0.0;                         ///< of it [m]
  SurfacePoints surface;                       ///< dense samples, for registration
  SurfaceField field;                          ///< over them
  SurfaceTree tree;                            ///< over the mesh itself
  SurfaceSigma sigma;                          ///< of all of these
  std::vector<ModelSide> sides;
  MadeOnce<Features> features;             ///< see `features_of`
  MadeOnce<std::vector<Pose>> symmetries;  ///< see `symmetries_of`
  std::vector<ModelSample> samples;        ///< those of `surface` again, to be read at random
  double drawn_radius = 0.0;               ///< of the vertices of `drawn` about `centre` [m]
};

struct DetectionModels::Data {
  std::vector<DetectionModel> models;
  DetectionOptions options;  ///< that the models were made with
  std::vector<std::vector<StoneIndex>>
      rivals;  ///< of each model, the others of like shape: detection/identity.hpp
};

/// Descriptors of a model's keypoints. Most scenes are explained without: they are made on first use.
[[nodiscard]] const Features& features_of(const DetectionModel& model, const DetectionOptions& options);

/// The T_O_S that bring a model nearly onto itself (turns_onto_itself), made on first use.
[[nodiscard]] const std::vector<Pose>& symmetries_of(const DetectionModel& model);

/// Prepares one stone.
[[nodiscard]] DetectionModel make_detection_model(const Stone& stone);

/// True if `p_C` lies within `margin` of the surface of the model at T_C_O, or of where that may be, or
/// inside it.
[[nodiscard]] bool explains(const DetectionModel& model, const Pose& T_C_O, const Eigen::Vector3f& p_C,
                            double margin);

/// A scene without the points and pixels of some stones: what is left to explain. Nothing changes for no
/// stones.
[[nodiscard]] DetectionScene without_stones(DetectionScene scene, const DetectionModels::Data& data,
                                            std::span<const KnownStone> stones);

}  // namespace stonestack::detection
