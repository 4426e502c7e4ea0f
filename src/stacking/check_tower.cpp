#include <algorithm>

#include "physics/shape.hpp"
#include "stacking/block_balance.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::stacking {
namespace {

// m: stones that stand touch; what is deeper says nothing of how they stand
constexpr double kOverlap = 0.002;
constexpr int kConeEdges = 64;  // of a friction cone; the search makes do with 8, 8 % on the safe side
constexpr int kDirections = 16;

/// The stack of a scene, or its wall.
Stack read_stack(const std::string& path, const SceneFile& scene, const Catalogue& catalogue) {
  if (scene.stack.empty() && scene.wall.empty())
    throw FileError(path, "has no stack and no wall", "list its stones from the table up");
  Stack stack;
  for (const NamedPose& item : scene.stack.empty() ? scene.wall : scene.stack)
    stack.stones.push_back({catalogue.index(item.stone), item.T_W_O});
  return stack;
}

/// Contact shapes of the stack's stones; those of others are null.
ShapeList shapes_of(const Stack& stack, const Catalogue& catalogue) {
  ShapeList shapes(catalogue.stones.size());
  for (const PlacedStone& placed : stack.stones) {
    auto& shape = at(shapes, placed.stone);
    if (!shape) shape = make_contact_shapes({catalogue[placed.stone]}).front();
  }
  return shapes;
}

void refuse_impossible(const std::string& path, const ShapeList& shapes, const Stack& stack) {
  for (const PlacedStone& placed : stack.stones) {
    const ContactShape& shape = *at(shapes, placed.stone);
    const std::string wrong = impossible(shape);
    if (!wrong.empty()) throw FileError(path, concat("stone ", shape.name, ": ", wrong), "repair the stone");
  }
  const std::string overlap = overlap_of(shapes, stack, kOverlap);
  if (!overlap.empty()) throw FileError(path, overlap, "give poses at which the stones touch");
}

/// Contacts collected over several steps, those of a pair within 1 mm and 3 deg once.
std::vector<BlockContact> distinct_contacts(const std::vector<Contact>& contacts) {
  std::vector<BlockContact> kept;
  for (const Contact& c : contacts) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const BlockContact& other) {
      const Contact& o = other.contact;
      return o.below == c.below && o.above == c.above && (o.p_W - c.p_W).squaredNorm() < 1e-6 &&
             o.n_W.dot(c.n_W) > 0.9986;
    });
    if (!known) kept.push_back({c, 1.0});
  }
  return kept;
}

}  // namespace

TowerCheck check_tower(const std::string& scene_path, const Catalogue& catalogue, double friction,
                       double seconds) {
  TowerCheck check;
  check.friction = friction;
  check.seconds = seconds;
  const SceneFile scene = read_scene_file(scene_path);
  check.wall = scene.stack.empty();
  check.stack = read_stack(scene_path, scene, catalogue);
  const ShapeList shapes = shapes_of(check.stack, catalogue);
  refuse_impossible(scene_path, shapes, check.stack);
  StandOptions stand;
  stand.friction = friction;
  stand.seconds = seconds;
  check.verdict = judge_stack(shapes, check.stack, stand);
  check.statics = stack_statics(shapes, check.stack, friction);
  EquilibriumOptions options;
  options.friction = friction;
  options.directions = kDirections;
  options.cone_edges = kConeEdges;
  check.equilibrium = solve_equilibrium(check.statics.bodies, check.statics.contacts, options);
  check.balance = block_balance(check.statics.bodies, distinct_contacts(check.statics.contacts), friction,
                                -Eigen::Vector3d::UnitZ());
  return check;
}

}  // namespace stonestack::stacking
