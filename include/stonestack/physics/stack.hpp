#pragma once
#include <memory>
#include <string>
#include <vector>

#include "stonestack/physics/equilibrium.hpp"
#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::physics {

struct ContactShape;  // private: surface and mass of a stone, arranged for contact
/// Contact shapes of stones, in the order of a catalogue; each is immutable and shared between threads.
using ShapeList = std::vector<std::shared_ptr<const ContactShape>>;
/// Contact shapes of the stones' scans, made in parallel.
/// @throws InvalidArgument for a scan that is not closed and for a mass that is not possible.
[[nodiscard]] ShapeList make_contact_shapes(const std::vector<Stone>& stones);
/// Contact shapes that the stones may have instead, as well as their surfaces are known (`Stone::surface`):
/// `count` draws in the order of the stones, null for a stone that is known as it is.
/// @return empty where all are
/// @throws InvalidArgument as `make_contact_shapes`.
[[nodiscard]] std::vector<ShapeList> make_possible_shapes(const std::vector<Stone>& stones, int count = 8);

/// Stones stacked from the table up: stones[0] lies on the table, stones[i] on stones[i-1]. Indices into a
/// ShapeList.
struct Stack {
  std::vector<PlacedStone> stones;  ///< stones from the table up
};

/// How a stack is judged.
struct StandOptions {
  double friction = 0.1;        ///< friction coefficient, stone on stone and on the table
  double seconds = 10.0;        ///< simulated
  int iterations = 200;         ///< iterations of the contact solver in each step
  double step = 0.001;          ///< finer than the search takes (docs/measurements.md, Contact) [s]
  double max_shift = 0.001;     ///< [m]
  double max_turn = 0.0174533;  ///< [rad] (1 deg)
  double touch_gap = 0.001;     ///< nearer counts as touching for the clean rule [m]
  double still = 0.0;  ///< motion in 0.1 s [m] below which, three times running, the rest is not simulated
  double fall =
      1.0;  ///< time [s] that a stack which moved is given to show which stones stay; 0: it is not asked
  /// frame O, a level each or none at all [m]: how far from the centre of mass that is known the true one
  /// lies.
  std::vector<Eigen::Vector3d> com_error_O = {};
  int held = 0;  ///< levels from the table up that are held where they are, and not judged
};

/// Does it stand, cleanly? A stack is clean if stone i touches only stones i-1 and i+1, and only stone 0 the
/// table.
struct StandVerdict {
  bool stands = false;      ///< true if no stone moved beyond the limits
  bool clean = false;       ///< true if the stack is clean
  int standing = 0;         ///< stones from the bottom that stayed and are clean
  double shift = 0.0;       ///< largest of any stone [m]
  double turn = 0.0;        ///< [rad]
  std::vector<Pose> T_W_O;  ///< at the end
  std::string reason;       ///< when it does not stand or is not clean: which stone (from 0), what happened
};
/// Simulates the stack with every stone dynamic and judges it.
[[nodiscard]] StandVerdict judge_stack(const ShapeList& shapes, const Stack& stack,
                                       const StandOptions& options = {});

/// Shaking of the table: a level acceleration that swings, then half a second of rest.
struct Shake {
  double acceleration = 2.0;  ///< amplitude [m/s^2]
  double frequency = 2.4;     ///< [Hz]
  double seconds = 0.7;       ///< duration [s]
};
/// Shakes the stack with every stone dynamic, once along x and once along y, each from its given poses; of
/// the options friction, step, iterations, touch_gap and com_error_O count.
/// @return stones from the bottom that are still a clean stack after the worse of the two
[[nodiscard]] int standing_when_shaken(const ShapeList& shapes, const Stack& stack,
                                       const StandOptions& options = {}, const Shake& shake = {});

/// Contacts of a stack as it lies (no simulation): features of two stones, or of a stone and the table,
/// within `gap` (at most 1 mm) of each other, reduced to at most 16 a pair (the deepest and the most spread).
/// Indices are levels of the stack.
[[nodiscard]] std::vector<Contact> geometric_contacts(const ShapeList& shapes, const Stack& stack,
                                                      double gap);
/// A stack as statics sees it.
struct StackStatics {
  std::vector<StaticBody> bodies;  ///< mass and centre of mass of each level that is not held
  std::vector<Contact> contacts;   ///< collected over a short settle; indices are those of `bodies`
};
/// @param held levels from the table up that are held where they are: ground, as the table
[[nodiscard]] StackStatics stack_statics(const ShapeList& shapes, const Stack& stack, double friction,
                                         int held = 0);
/// Equilibrium of a stack from `stack_statics`.
[[nodiscard]] Equilibrium stack_equilibrium(const ShapeList& shapes, const Stack& stack,
                                            const EquilibriumOptions& options = {}, int held = 0);

/// Why a stone cannot be: mass not positive, inertia not possible, centre of mass outside its hull, nothing
/// finite.
/// @return empty if it can.
[[nodiscard]] std::string impossible(const ContactShape& shape);

/// Names two stones of a stack that cut into each other, or one that reaches through the table, by more than
/// `allowed` (m; 8 mm: more than any measurement errs).
/// @return empty if there are none.
[[nodiscard]] std::string overlap_of(const ShapeList& shapes, const Stack& stack, double allowed = 0.008);

}  // namespace stonestack::physics

#pragma GCC visibility pop
