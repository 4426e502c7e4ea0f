#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::detection {

/// An alternative explanation: another pose of a stone of nearly symmetric shape, or another stone of like
/// shape.
struct AlternativePose {
  Pose T_C_O = Pose::Identity();  ///< alternative pose of the stone in the camera frame
  double weight = 0.0;            ///< of all together 1
  StoneIndex stone = kNoStone;    ///< index into the models
};

/// Where a stone was found.
struct Detection {
  StoneIndex stone = kNoStone;    ///< index into the models
  Pose T_C_O = Pose::Identity();  ///< pose of the stone in the camera frame
  double score = 0.0;  ///< visibility-aware, at most 1; accepted from `DetectionOptions::accept_score` on
  double inlier_ratio = 0.0;  ///< the paper's, over visible model points
  double visible = 0.0;       ///< share of the model's surface that this view saw
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Zero();  ///< (translation m, rotation rad) in C; spans the stone's own
                                            ///< `alternatives`, too, supposing that it is this stone
  double certainty = 1.0;  ///< of this stone in this pose: a cube has 24, and another stone may look alike
  std::vector<AlternativePose> alternatives;  ///< what fits nearly as well, the best first
};

/// Losses of a pose's score, by what contradicts it: together they are 1 - score.
struct ScoreLosses {
  double misfit = 0.0;         ///< seen surface lies off the model's, or is turned from it
  double seen_through = 0.0;   ///< surface behind the model is seen where the model should be
  double in_front = 0.0;       ///< surface lies just in front of the model
  double hidden = 0.0;         ///< something further in front hides the model
  double beside = 0.0;         ///< surface goes on just off the model's surface
  double outline = 0.0;        ///< surface goes on smoothly across the model's outline
  double below = 0.0;          ///< the model reaches below the table or another support
  double bend = 0.0;           ///< the seen surface does not bend as the model's does
  double without_depth = 0.0;  ///< much of the model has no depth where it should be seen
  double loose = 0.0;          ///< flat surface without the model's outline fits in many places
};

struct DetectionTrace;

/// Detections in one frame, or in several of one scene.
struct DetectionResult {
  std::vector<Detection> detections;  ///< at most `copies` a model, best score first
  std::optional<Plane> table_C;       ///< normal towards the camera
  std::string note;  ///< why nothing was found, or what is odd about the image, for a person; empty otherwise
  double depth_scale = 1.0;        ///< by how much seen depths are too large for the stones' sizes, ...
  double depth_scale_sigma = 0.0;  ///< ... and its standard deviation; 0: unobservable
  std::shared_ptr<const DetectionTrace> trace;  ///< what each stage saw, with DetectionOptions::trace
};

/// One depth image of several, and where it was taken from.
struct DepthView {
  DepthImage image;               ///< depth image, in the frame of its own camera
  Pose T_W_C = Pose::Identity();  ///< W: any frame that all views share
};

/// Stages and limits of detection.
struct DetectionOptions {
  std::string method = "default";     ///< default, or paper (method.hpp): judged by the inlier ratio
  std::string keypoints = "voxel";    ///< voxel, iss
  std::string descriptor = "shot";    ///< shot, fpfh, iss, rops
  std::string matching = "exact";     ///< exact, kdtree (the same matches)
  double nearest = 0.15;              ///< depth range that is looked at [m]
  double farthest = 2.0;              ///< [m]
  int copies = 1;                     ///< of each model at most, in one scene
  bool sweep = true;                  ///< also try all orientations on each cluster
  double accept_score = 0.85;         ///< at least; 0.89 in a clean image of one view (measured)
  double accept_inlier_ratio = 0.75;  ///< with paper
  double bias_sigma = 0.0005;  ///< smooth error of a depth image, where no table shows what it is ... [m]
  bool trace = false;          ///< keep what each stage saw
  int seed = 1;                ///< seed of every random draw
};
[[nodiscard]] FieldList fields(DetectionOptions& options);

/// A stone whose pose is known: placed before, or held.
struct KnownStone {
  StoneIndex stone = kNoStone;    ///< index into the models
  Pose T_C_O = Pose::Identity();  ///< known pose in the camera frame
};

/// Knowledge of a scene before it is observed.
struct SceneKnowledge {
  std::vector<KnownStone> stones;  ///< their points are taken out of the scene, and they may hide others
  std::optional<Plane> table_C;    ///< where the table is, within 3 cm and 10 deg, from the camera's pose
};

/// Stones prepared for detection: resampled surfaces, descriptors. Made once, shared between frames and
/// threads.
class DetectionModels {
 public:
  /// Prepares the models of `stones` for the descriptors that the options name.
  DetectionModels(std::span<const Stone> stones, const DetectionOptions& options = {});
  ~DetectionModels();
  /// Takes over the models of another.
  DetectionModels(DetectionModels&&) noexcept;
  /// Takes over the models of another.
  DetectionModels& operator=(DetectionModels&&) noexcept;
  struct Data;
  /// Prepared models, private to detection.
  [[nodiscard]] const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

/// Finds the stones `wanted` (indices; all if empty; one named several times in as many copies at least) in
/// one depth image (paper §2). Never throws for what a camera may show: an empty or senseless image gives no
/// detections and a note.
[[nodiscard]] DetectionResult detect_stones(const DepthImage& image, const DetectionModels& models,
                                            std::span<const StoneIndex> wanted = {},
                                            const DetectionOptions& options = {},
                                            const SceneKnowledge& known = {});

/// Detects from several camera poses: hypotheses from each view, one verdict over all, so that what one view
/// hides another may show. Views are first aligned by what they see (hand-eye and arm err by a millimetre or
/// two). Results and `known` are in C, the camera frame of the first view.
/// @throws InvalidArgument for no view.
[[nodiscard]] DetectionResult detect_stones(std::span<const DepthView> views, const DetectionModels& models,
                                            std::span<const StoneIndex> wanted = {},
                                            const DetectionOptions& options = {},
                                            const SceneKnowledge& known = {});

/// Evidence of one pixel on a model that is drawn into the image.
enum class PixelEvidence : std::uint8_t {
  kNone,         ///< the model is not there
  kFits,         ///< the seen surface is the model's
  kSeenThrough,  ///< the surface behind is seen
  kInFront,      ///< surface just in front of the model
  kHidden,       ///< something further in front hides the model
  kNoDepth,      ///< the camera gave no depth
};

/// Why a stone was found or not.
struct Explanation {
  StoneIndex stone = kNoStone;  ///< index into the models
  std::string stage;  ///< where its search ended: found, no surface, no hypothesis, no pose, refuted,
                      ///< claimed by another, left out, or not searched
  std::string text;   ///< what happened and what may help, for a person
  std::optional<Detection> best;        ///< the pose that came nearest; empty where none was tried
  double wanted = 0.0;                  ///< score that this pose would have needed
  ScoreLosses lost;                     ///< what its score lost
  std::vector<PixelEvidence> evidence;  ///< of each pixel at this pose, row by row; empty without one
};

/// Says at which stage of a search a stone was lost, from the trace of `result`, which `detect_stones` found
/// in this image with these models and options.
/// @throws InvalidArgument for a result without a trace (DetectionOptions::trace).
[[nodiscard]] Explanation explain_stone(const DepthImage& image, const DetectionResult& result,
                                        const DetectionModels& models, StoneIndex stone,
                                        const DetectionOptions& options = {},
                                        const SceneKnowledge& known = {});

/// Refines known poses: a stone is expected at T_C_O_guess (within about 15 mm, 15 deg); empty if it is not
/// there.
[[nodiscard]] std::optional<Detection> track_stone(const DepthImage& image, const DetectionModels& models,
                                                   StoneIndex stone, const Pose& T_C_O_guess,
                                                   const DetectionOptions& options = {},
                                                   const SceneKnowledge& known = {});

/// The options that a method stands for, to be changed further: default, or paper (section 2: RoPS, kd-tree,
/// one turn, the inlier ratio). Throws InvalidArgument for any other.
[[nodiscard]] DetectionOptions options_of(const std::string& method);

/// The table in one depth image, in C with the normal towards the camera: the plane that `detect_stones` will
/// report, found in a small part of the time.
/// @return empty where the image shows no plane with little below it.
[[nodiscard]] std::optional<Plane> find_table(const DepthImage& image, const DetectionOptions& options = {});

/// T_W_C of a camera whose pose is unknown, by the table that it sees: the table is z = 0 of W with z up, the
/// point of the table below the camera is the origin, and x of W runs along the image's x.
[[nodiscard]] Pose camera_over(const Plane& table_C);

/// Which part of the table (z = 0 of W) a view shows, in square cells.
struct TableView {
  double cell = 0.02;                    ///< side of a cell [m]
  std::vector<Eigen::Vector2d> p_W;      ///< centres of the cells in which the bare table is seen, sorted
  Eigen::Vector2d p_W_middle{0.0, 0.0};  ///< of the box around them
  std::vector<Eigen::Vector3d> above_W;  ///< surface 1 cm and more above the table, one point a cube of 5 mm
};
/// Cells count where a depth lies within 4 mm of the plane.
[[nodiscard]] TableView view_of_table(const DepthImage& image, const Plane& table_C, const Pose& T_W_C,
                                      const DetectionOptions& options = {});

/// Present state of a stone that was placed before.
struct TrackedStone {
  /// State of a stone against its expected pose.
  enum class Status {
    kInPlace,  ///< where it was
    kMoved,    ///< seen elsewhere, by the distance `moved`
    kFallen,   ///< seen elsewhere and lower
    kUnseen,   ///< hidden, or gone
  };
  StoneIndex stone = kNoStone;         ///< index into the models
  Status status = Status::kUnseen;     ///< state of the stone in the image
  std::optional<Detection> detection;  ///< empty with kUnseen
  PoseDifference moved;                ///< from where it was; of the bounding sphere's centre
};
[[nodiscard]] std::string to_text(TrackedStone::Status status);

/// Present state of all of them.
struct TrackResult {
  std::vector<TrackedStone> stones;  ///< one entry an expected stone, in their order
  std::string note;                  ///< why the search found none of those that are not there, for a person
};

/// When a stone counts as moved or fallen.
struct TrackOptions {
  double moved_shift = 0.003;  ///< [m]
  double fallen_drop = 0.015;  ///< of the centre, towards the table [m]
};
[[nodiscard]] FieldList fields(TrackOptions& options);

/// Refines every expected stone from its last pose (track_stone); those that are not there are searched for
/// in the rest of the scene. A stone that is expected several times is searched for in as many copies. Stones
/// of `known` (for example held ones) are neither searched nor allowed to explain anything else.
[[nodiscard]] TrackResult track_stones(const DepthImage& image, const DetectionModels& models,
                                       std::span<const KnownStone> expected,
                                       const DetectionOptions& options = {}, const SceneKnowledge& known = {},
                                       const TrackOptions& limits = {});

/// Writes DIR/turn_N/: surface.ply, cluster_K.ply, keypoints.ply, matches.ply (keypoints that have one),
/// hypotheses.ply (where each has the middle of its stone), candidate_K.ply (the model at the pose) and
/// stages.json with matches, hypotheses and candidates; no PLY of what a turn has none of. Throws FileError.
void write_trace(const std::string& folder, const DetectionTrace& trace, std::span<const Stone> stones);

}  // namespace stonestack::detection

#pragma GCC visibility pop
