#include "motion/collision/proof.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "motion/collision/collision_shapes.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

constexpr double kCoarse = 0.03;  // m: while things move further, exact distances hardly ever decide

enum class Answer { kClear, kUndecided, kHit };

/// A mover and what it could touch.
struct Couple {
  enum class With { kTable, kPiece, kMover, kWorkspace, kWall };
  With with = With::kTable;
  std::size_t mover = 0, other = 0;
  double padding = 0.0;  ///< [m]
};

/// The middle of a piece of the motion, and how far the joints turn from there.
struct Middle {
  std::array<Pose, 7> pose;
  Joints turn;
  Middle(const CollisionShapes& shapes, const Joints& from, const Joints& to)
      : pose(link_poses(shapes.robot, 0.5 * (from + to))), turn((0.5 * (to - from)).cwiseAbs()) {}
};

/// A mover at a middle.
struct ProofPlaced {
  Segment axis;
  Bounds box;
  double shift = 0.0;
  ProofPlaced() = default;
  ProofPlaced(const Middle& middle, const Mover& mover)
      : axis{middle.pose[mover.link] * mover.core.axis.a, middle.pose[mover.link] * mover.core.axis.b},
        box(bounds(axis)),
        shift(max_shift(middle.pose, middle.turn, axis, mover.core.reach, mover.link)) {}
};

Answer answer(double distance, double padding, double shift) {
  if (distance <= padding) return Answer::kHit;
  return distance > padding + shift ? Answer::kClear : Answer::kUndecided;
}

/// The tool's tip, a point of link 6 and in its frame; for robots with a workspace.
Eigen::Vector3d tip_of_link(const CollisionShapes& shapes) {
  return (shapes.robot.T_6_F * shapes.robot.workspace->T_F_T).translation();
}

class Proof {
 public:
  Proof(const CollisionShapes& shapes, double resolution) : shapes_(shapes), resolution_(resolution) {}

  bool holds(const Joints& from, const Joints& to) {
    undecided_.clear();
    const Middle middle(shapes_, from, to);
    return look_at_all(middle) && halves_hold(from, to, 0);
  }

 private:
  /// The undecided pairs from `first` on were left by the piece between `from` and `to`.
  bool halves_hold(const Joints& from, const Joints& to, std::size_t first) {
    const std::size_t last = undecided_.size();
    if (first == last) return true;
    if ((to - from).cwiseAbs().maxCoeff() <= resolution_) return false;
    const Joints middle = 0.5 * (from + to);
    for (const auto& [a, b] : {std::pair(from, middle), std::pair(middle, to)}) {
      const bool free = look_again(Middle(shapes_, a, b), first, last) && halves_hold(a, b, last);
      undecided_.resize(last);
      if (!free) return false;
    }
    return true;
  }

  /// Appends the pairs of [first, last) that remain undecided. False: a collision.
  bool look_again(const Middle& middle, std::size_t first, std::size_t last) {
    std::size_t placed_mover = std::numeric_limits<std::size_t>::max();
    ProofPlaced placed;
    for (std::size_t k = first; k < last; ++k) {
      const Couple couple = undecided_[k];
      if (couple.mover != placed_mover) placed = ProofPlaced(middle, shapes_.movers[couple.mover]);
      placed_mover = couple.mover;
      if (!note(ask(middle, placed, couple), couple)) return false;
    }
    return true;
  }

  bool look_at_all(const Middle& middle) {
    for (std::size_t i = 0; i < shapes_.movers.size(); ++i)
      placed_[i] = ProofPlaced(middle, shapes_.movers[i]);
    ProofPlaced gripper;
    const bool has_gripper = shapes_.first_gripper < shapes_.movers.size();
    if (has_gripper) {
      gripper.axis = {middle.pose[6] * shapes_.gripper.axis.a, middle.pose[6] * shapes_.gripper.axis.b};
      gripper.box = bounds(gripper.axis);
      gripper.shift = max_shift(middle.pose, middle.turn, gripper.axis, shapes_.gripper.reach, 6);
    }
    const Couple tip{Couple::With::kWorkspace, 0, 0, kWorkspaceMargin};
    if (shapes_.robot.workspace && !note(check_workspace(middle), tip)) return false;
    for (std::size_t i = 0; i < shapes_.movers.size(); ++i) {
      const Couple couple{Couple::With::kTable, i, 0, shapes_.movers[i].table_padding};
      if (shapes_.movers[i].sees_table && !note(ask(middle, placed_[i], couple), couple)) return false;
    }
    for (std::size_t k = 0; k < shapes_.walls.size(); ++k)
      for (std::size_t i = 0; i < shapes_.movers.size(); ++i) {
        const Couple couple{Couple::With::kWall, i, k, kWorkspaceMargin};
        if (shapes_.movers[i].link >= kFirstFencedLink && !note(ask(middle, placed_[i], couple), couple))
          return false;
      }
    for (const auto& group : shapes_.groups) {
      const bool gripper_is_far =
          has_gripper &&
          apart(gripper.box, group.box, shapes_.gripper.reach + gripper.shift + group.gripper_padding);
      const std::size_t last = gripper_is_far ? shapes_.first_gripper : shapes_.movers.size();
      for (std::size_t i = 0; i < last; ++i) {
        const double reach = shapes_.movers[i].core.reach + group.padding[i] + placed_[i].shift;
        if (group.sees[i] == 0 || apart(placed_[i].box, group.box, reach)) continue;
        for (std::size_t k = group.first; k < group.last; ++k) {
          const Couple couple{Couple::With::kPiece, i, k, group.padding[i]};
          if (!note(ask(middle, placed_[i], couple), couple)) return false;
        }
      }
    }
    for (const auto& [i, j] : shapes_.pairs) {
      const double reach = shapes_.movers[i].core.reach + shapes_.movers[j].core.reach;
      if (apart(placed_[i].box, placed_[j].box, reach + shapes_.rules.self_padding + placed_[j].shift))
        continue;
      const Couple couple{Couple::With::kMover, j, i, shapes_.rules.self_padding};
      if (!note(ask(middle, placed_[j], couple), couple)) return false;
    }
    return true;
  }

  bool note(Answer answer, const Couple& couple) {
    if (answer == Answer::kUndecided) undecided_.push_back(couple);
    return answer != Answer::kHit;
  }

  [[nodiscard]] Answer ask(const Middle& middle, const ProofPlaced& placed, const Couple& couple) const {
    switch (couple.with) {
      case Couple::With::kTable:
        return ask_plane(shapes_.n_R_table, shapes_.table_offset, middle, placed, couple);
      case Couple::With::kWall: {
        const FenceWall& wall = shapes_.walls[couple.other];
        return ask_plane(wall.n_R, wall.offset, middle, placed, couple);
      }
      case Couple::With::kPiece:
        return ask_piece(middle, placed, couple);
      case Couple::With::kWorkspace:
        return check_workspace(middle);
      default:
        return ask_mover(middle, placed, couple);
    }
  }

  [[nodiscard]] Answer check_workspace(const Middle& middle) const {
    const Eigen::Vector3d p_R = middle.pose[6] * tip_of_link(shapes_);
    const double shift = max_shift(middle.pose, middle.turn, {p_R, p_R}, 0.0, 6);
    return answer(workspace_left(shapes_, middle.pose), kWorkspaceMargin, shift);
  }

  /// The plane n.p + offset = 0 in R.
  [[nodiscard]] Answer ask_plane(const Eigen::Vector3d& n_R, double offset, const Middle& middle,
                                 const ProofPlaced& placed, const Couple& couple) const {
    const Mover& mover = shapes_.movers[couple.mover];
    const double axis = std::min(n_R.dot(placed.axis.a), n_R.dot(placed.axis.b));
    if (axis + offset - mover.core.reach > couple.padding + placed.shift) return Answer::kClear;
    return answer(height_above(n_R, offset, mover, middle.pose[mover.link]), couple.padding, placed.shift);
  }

  [[nodiscard]] Answer ask_piece(const Middle& middle, const ProofPlaced& placed,
                                 const Couple& couple) const {
    const Mover& mover = shapes_.movers[couple.mover];
    const auto& piece = shapes_.obstacles[couple.other];
    const double bound = mover.core.reach + couple.padding + placed.shift;
    if (apart(placed.box, piece.box, bound)) return Answer::kClear;
    const double ball = bound + piece.sphere;
    if (squared_distance(placed.axis, piece.centre) > ball * ball) return Answer::kClear;
    if (squared_distance_to_box(placed.axis, piece.box.low, piece.box.high) > bound * bound)
      return Answer::kClear;
    if (placed.shift > kCoarse) return Answer::kUndecided;
    const double hulls =
        hull_distance(mover.core, to_bullet(middle.pose[mover.link]), piece.core, btTransform::getIdentity());
    return answer(hulls, mover.core.radius + couple.padding, placed.shift);
  }

  /// Seen from the earlier link only the joints between the two move the later one.
  [[nodiscard]] Answer ask_mover(const Middle& middle, const ProofPlaced& placed,
                                 const Couple& couple) const {
    const Mover &a = shapes_.movers[couple.other], &b = shapes_.movers[couple.mover];
    const Segment axis{middle.pose[a.link] * a.core.axis.a, middle.pose[a.link] * a.core.axis.b};
    const double reach = a.core.reach + b.core.reach + couple.padding;
    if (apart(bounds(axis), placed.box, reach + placed.shift)) return Answer::kClear;
    const double axes = squared_distance(axis, placed.axis);
    const double far = reach + placed.shift;
    if (axes > far * far) return Answer::kClear;
    const double shift = max_shift(middle.pose, middle.turn, placed.axis, b.core.reach, b.link, a.link);
    const double near = reach + shift;
    if (axes > near * near) return Answer::kClear;
    // Between capsules of the arm these are the distances.
    if (b.part == Mover::Part::kArm) return answer(std::sqrt(axes), reach, shift);
    if (shift > kCoarse) return Answer::kUndecided;
    if (b.part == Mover::Part::kGripper) {
      const Pose T_T_R = (middle.pose[6] * shapes_.T_6_T).inverse();
      const Segment axis_T{T_T_R * axis.a, T_T_R * axis.b};
      const double box = std::sqrt(squared_distance_to_box(axis_T, b.box_T.min(), b.box_T.max()));
      return answer(box, a.core.radius + couple.padding, shift);
    }
    const double hulls =
        hull_distance(a.core, to_bullet(middle.pose[a.link]), b.core, to_bullet(middle.pose[b.link]));
    return answer(hulls, a.core.radius + couple.padding, shift);
  }

  const CollisionShapes& shapes_;
  double resolution_;
  std::array<ProofPlaced, CollisionShapes::kMaxMovers> placed_;
  std::vector<Couple> undecided_;
};

}  // namespace

double workspace_left(const CollisionShapes& shapes, const std::array<Pose, 7>& pose) {
  if (!shapes.robot.workspace) return std::numeric_limits<double>::infinity();
  const ToolWorkspace& workspace = *shapes.robot.workspace;
  const Eigen::Vector3d p_W = workspace.T_W_R * (pose[6] * tip_of_link(shapes));
  return std::min((p_W - workspace.box.min()).minCoeff(), (workspace.box.max() - p_W).minCoeff());
}

double height_above(const Eigen::Vector3d& n_R, double offset, const Mover& mover, const Pose& T_R_link) {
  const Eigen::Vector3d n = T_R_link.linear().transpose() * n_R;
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& p : mover.core.points) lowest = std::min(lowest, n.dot(p));
  return lowest + n_R.dot(T_R_link.translation()) + offset - mover.core.radius;
}

double max_shift(const std::array<Pose, 7>& pose, const Joints& turn, const Segment& axis, double reach,
                 std::size_t link, std::size_t base) {
  double shift = 0.0;
  for (std::size_t j = link; j > base; --j) {
    const Eigen::Vector3d p = pose[j].translation(), z = pose[j].linear().col(2);
    const double off = std::max((axis.a - p).cross(z).squaredNorm(), (axis.b - p).cross(z).squaredNorm());
    shift += turn[static_cast<Eigen::Index>(j) - 1] * (std::sqrt(off) + reach + shift);
  }
  return shift;
}

bool is_free_continuously(const CollisionShapes& shapes, const Joints& a, const Joints& b,
                          double resolution) {
  constexpr double kPiece = 0.2;  // rad: within longer ones something could nearly always reach an obstacle
  const double pieces = std::max(1.0, std::ceil((b - a).cwiseAbs().maxCoeff() / kPiece));
  Proof proof(shapes, resolution);
  for (double k = 0.0; k < pieces; k += 1.0)
    if (!proof.holds(a + (b - a) * (k / pieces), a + (b - a) * ((k + 1.0) / pieces))) return false;
  return true;
}

}  // namespace stonestack::motion
