#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "physics/shape.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/physics/equilibrium.hpp"

namespace stonestack::physics {

/// Settings of a Bullet world. Source of the defaults: measured, docs/measurements.md.
struct WorldOptions {
  double friction = 0.1;        ///< stone on stone and stone on table, unless given for a pair
  double step = 1.0 / 240.0;    ///< [s]
  int iterations = 50;          ///< over all touches, at most; 200 for a verdict
  double gravity = 9.81;        ///< [m/s^2]
  double contact_gap = 0.0005;  ///< contacts further apart do not count [m]
  double linear_damping = 0.0;
  double angular_damping = 0.0;
};
[[nodiscard]] FieldList fields(WorldOptions& options);

/// Velocity of a body at its centre of mass, world axes.
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d w = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// Stones and boxes on a table (z = 0) in Bullet. Contact is exact: vertices on faces and edges on edges of
/// the scans as they are, concave or not, without margins; friction cones are round. Cheap to make (small
/// pools); make one per trial: a reused world is not bit-identical. Not thread-safe; one per thread. Poses
/// are of frame O.
class World {
 public:
  explicit World(const WorldOptions& options = {});
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// Adds a stone; returns its index (0, 1, ... over stones and boxes together, in order). A fixed stone does
  /// not move.
  int add_stone(std::shared_ptr<const ContactShape> shape, const Pose& T_W_O, bool fixed = false);
  /// Adds a box that moves only as commanded (gripper, obstacle), full side lengths in metres.
  int add_box(const Eigen::Vector3d& size, const Pose& T_W_box);
  /// Moves a box (or a fixed stone) to a pose over the next step, so that it pushes with the right velocity.
  void move_to(int body, const Pose& T_W_body);
  /// Puts a body at a pose at rest, at once. For setting up.
  void place(int body, const Pose& T_W_body, const Twist& twist = {});
  void set_fixed(int body, bool fixed);
  /// Friction of one pair of bodies; overrides the world's.
  void set_pair_friction(int a, int b, double friction);
  /// Turns contact between two bodies off or on (a held stone and its fingers).
  void set_contact(int a, int b, bool enabled);
  /// Force (N) at the centre of mass and torque (Nm), world axes, for the next step only.
  void apply(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque = Eigen::Vector3d::Zero());
  void set_gravity(const Eigen::Vector3d& g_W);
  /// Lets a stone's weight act beside its centre of mass, by `offset_O` (m, frame O), from now on: what a
  /// centre of mass that is only known to a millimetre or two may do. Inertia stays as it is.
  void set_weight_offset(int body, const Eigen::Vector3d& offset_O);

  /// One step of `options().step`.
  void step();
  /// One step of another length, s. Impulses are carried over, so step lengths may change at any time.
  void step(double dt);
  /// As many steps of `options().step` as fit into `seconds`, at least one.
  void run(double seconds);

  [[nodiscard]] int bodies() const;
  [[nodiscard]] Pose pose(int body) const;
  [[nodiscard]] Twist twist(int body) const;
  /// Kinetic energy of translation and rotation [J].
  [[nodiscard]] double kinetic_energy(int body) const;
  /// Contacts of the last step with gap at most `contact_gap`; `below` is the table, else the body with the
  /// lower index. As found at the begin of the step, with the impulses of the step.
  [[nodiscard]] std::vector<Contact> contacts() const;
  [[nodiscard]] double time() const;
  [[nodiscard]] const WorldOptions& options() const;

 private:
  struct Bullet;
  std::unique_ptr<Bullet> bullet_;
};

}  // namespace stonestack::physics
