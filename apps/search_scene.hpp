#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "scene_input.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::apps {

/// Start of a search, as the command line names it.
struct SearchInput {
  std::string scene;        ///< scene file or view; empty: `stones` on the empty table
  std::string camera_pose;  ///< of a view; may be empty
  std::string stones;       ///< by name, comma-separated
  std::string site;         ///< x,y; may be empty
  bool world = false;       ///< the view is a cloud in the world frame
  bool for_robot = false;   ///< an arm is to be asked: W must be known
  DepthInput depth;
};

/// A search problem with the frame that it is stated in.
struct SearchStart {
  std::shared_ptr<const ShapeList> shapes;  ///< of the stones that occur, by catalogue index; others are null
  SearchProblem problem;
  /// Definition of W: cell (nothing was seen), scene_file, camera_pose, world_cloud, or table (found in a
  /// view); unknown before the input was read.
  std::string frame = "unknown";
  std::string frame_text;     ///< the same for a person
  std::optional<Pose> T_W_C;  ///< of a view that a camera took
  std::string site_text;      ///< where the tower stands or will stand, for a person; empty: as was asked
  bool seen = false;          ///< stones were found in a view
};

/// Reads and checks the input first, then prepares shapes, and finds the stones if the input is a view: which
/// tower stands there and which stones lie loose (`find_stack`). A view whose camera pose is unknown defines
/// W by the table that it shows; its tower is the one that stands there, else the site is the best place in
/// view. Throws FileError, InvalidArgument, and Error (nothing detected, no stable pose).
[[nodiscard]] SearchStart read_start(const SearchInput& input, const Catalogue& catalogue,
                                     const DetectionOptions& options);

}  // namespace stonestack::apps
