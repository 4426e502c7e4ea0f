#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "physics/shape.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/physics/equilibrium.hpp"

namespace stonestack::physics {

/// Settings of a world of rigid bodies. Source of the defaults: measured, docs/measurements.md.
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

/// A table that differs a little from the plane z = 0.
struct TableSurface {
  std::shared_ptr<const ContactShape> shape;  ///< closed mesh, in W
  /// Plane that touches the surface at the place x, y (m in W).
  std::function<Plane(const Eigen::Vector2d&)> tangent;
};

/// Stones and boxes on a table (z = 0), stepped by one engine or another: what the simulated cell and the
/// judges of towers need of it. Poses are of frame O. Make a fresh world per trial. Not thread-safe; one per
/// thread.
class RigidWorld {
 public:
  virtual ~RigidWorld() = default;

  /// Adds a stone; returns its index (0, 1, ... over stones and boxes together, in order). A fixed stone does
  /// not move.
  virtual int add_stone(std::shared_ptr<const ContactShape> shape, const Pose& T_W_O, bool fixed) = 0;
  /// Adds a box that moves only as commanded (gripper, obstacle), full side lengths in metres. Boxes meet
  /// stones only.
  virtual int add_box(const Eigen::Vector3d& size, const Pose& T_W_box) = 0;
  /// Puts a table in the place of the plane z = 0, after all stones and before the boxes. It takes the next
  /// index, and is kTable in frictions and contacts.
  virtual void add_table(const TableSurface& table) = 0;
  /// Moves a box (or a fixed stone) to a pose over the next step, so that it pushes with the right velocity.
  virtual void move_to(int body, const Pose& T_W_body) = 0;
  /// Puts a body at a pose at once. For setting up.
  virtual void place(int body, const Pose& T_W_body, const Twist& twist) = 0;
  /// Friction of one pair of bodies; overrides the world's.
  virtual void set_pair_friction(int a, int b, double friction) = 0;
  /// Lets the contact of a stone with a box give way, by `stiffness` [N/m] at each touch, as what is behind
  /// the box does. A rigid one presses without bound on a stone that is caught between box and table.
  virtual void set_pair_stiffness(int a, int b, double stiffness) = 0;
  /// Force (N) at the centre of mass and torque (Nm), world axes, for the next step only.
  virtual void apply(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) = 0;
  virtual void set_gravity(const Eigen::Vector3d& g_W) = 0;
  /// One step of `dt` s; its length may change at any time.
  virtual void step(double dt) = 0;

  [[nodiscard]] virtual Pose pose(int body) const = 0;
  [[nodiscard]] virtual Twist twist(int body) const = 0;
  /// Contacts of the last step with gap at most `contact_gap`; `below` is the table, else the body with the
  /// lower index. As found at the begin of the step, with the impulses of the step.
  [[nodiscard]] virtual std::vector<Contact> contacts() const = 0;

 protected:
  RigidWorld() = default;
  RigidWorld(RigidWorld&&) noexcept = default;
  RigidWorld& operator=(RigidWorld&&) noexcept = default;
};

/// The engines that step a world.
enum class EngineKind {
  kBullet,  ///< Bullet with exact contact between the scans' features and round friction cones (World)
  kOde      ///< Open Dynamics Engine with contacts of its own between the scans (OdeWorld)
};
/// "bullet" or "ode"; throws InvalidArgument for another name.
[[nodiscard]] EngineKind engine_named(const std::string& name);
[[nodiscard]] std::string to_text(EngineKind engine);
/// An empty world of that engine.
[[nodiscard]] std::unique_ptr<RigidWorld> make_rigid_world(EngineKind engine, const WorldOptions& options);

}  // namespace stonestack::physics
