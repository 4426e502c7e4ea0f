#pragma once
#include <functional>

#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to motion: joint paths made shorter.
namespace stonestack::motion {

/// Whether the straight motion between two configurations is allowed.
using MotionTest = std::function<bool(const Joints&, const Joints&)>;

/// Leaves way points out where the straight motion past them is allowed.
[[nodiscard]] JointPath without_detours(JointPath path, const MotionTest& is_free);

/// Tries `attempts` times to replace a random stretch of the path. Every second attempt goes straight in one
/// joint only, the others staying as they are (Geraerts and Overmars 2007, "partial shortcut"): wrists wander
/// where arm and shoulder cannot be straightened. After each attempt one way point is pulled towards the line
/// between its neighbours. What is replaced has passed `is_free`. Throws Interrupted.
[[nodiscard]] JointPath shortcut(JointPath path, const MotionTest& is_free, int attempts, Random& random);

/// The path with way points moved in beside pieces that are not free; empty where a few tries do not help.
/// All pieces of the result are free.
[[nodiscard]] JointPath repaired(const JointPath& path, const MotionTest& is_free, Random& random);

}  // namespace stonestack::motion
