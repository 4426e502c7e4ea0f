#pragma once

/// Umbrella header: the names that most programs need, in `stonestack`. Everything else keeps its room's
/// namespace.
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/experiment/experiment.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/modelling/model_objects.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack {
using core::data_path;
using detection::detect_stones;
using detection::DetectionModels;
using detection::DetectionResult;
using geometry::Cloud;
using geometry::DepthImage;
using geometry::Pose;
using hardware::Cell;
using hardware::CellLayout;
using kinematics::read_robot;
using kinematics::RobotModel;
using motion::plan_pick_and_place;
using physics::judge_stack;
using physics::make_contact_shapes;
using physics::ShapeList;
using physics::Stack;
using search::find_next_pose;
using search::plan_tower;
using search::SearchOptions;
using search::SearchProblem;
using search::SearchResult;
using simulation::SimulatedCell;
using stacking::build_tower;
using stacking::BuildOptions;
using stacking::RunResult;
using stone::Catalogue;
using stone::first_stones;
using stone::PlacedStone;
using stone::read_catalogue;
using stone::Stone;
using stone::StoneIndex;
}  // namespace stonestack
