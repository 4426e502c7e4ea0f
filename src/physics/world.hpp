#pragma once
#include <memory>
#include <vector>

#include "physics/rigid_world.hpp"

namespace stonestack::physics {

/// Stones and boxes on a table (z = 0) in Bullet. Contact is exact: vertices on faces and edges on edges of
/// the scans as they are, concave or not, without margins; friction cones are round. Cheap to make (small
/// pools); make one per trial: a reused world is not bit-identical.
class World final : public RigidWorld {
 public:
  explicit World(const WorldOptions& options = {});
  ~World() override;
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  int add_stone(std::shared_ptr<const ContactShape> shape, const Pose& T_W_O, bool fixed = false) override;
  void add_table(const TableSurface& table) override;
  int add_box(const Eigen::Vector3d& size, const Pose& T_W_box) override;
  void move_to(int body, const Pose& T_W_body) override;
  void place(int body, const Pose& T_W_body, const Twist& twist = {}) override;
  void set_fixed(int body, bool fixed);
  void set_pair_friction(int a, int b, double friction) override;
  void set_pair_stiffness(int a, int b, double stiffness) override;
  /// Turns contact between two bodies off or on (a held stone and its fingers).
  void set_contact(int a, int b, bool enabled);
  void apply(int body, const Eigen::Vector3d& force,
             const Eigen::Vector3d& torque = Eigen::Vector3d::Zero()) override;
  void set_gravity(const Eigen::Vector3d& g_W) override;
  /// Lets a stone's weight act beside its centre of mass, by `offset_O` (m, frame O), from now on: what a
  /// centre of mass that is only known to a millimetre or two may do. Inertia stays as it is.
  void set_weight_offset(int body, const Eigen::Vector3d& offset_O);

  /// One step of `options().step`.
  void step();
  /// Impulses are carried over to the next step, also to one of another length.
  void step(double dt) override;
  /// As many steps of `options().step` as fit into `seconds`, at least one.
  void run(double seconds);

  [[nodiscard]] int bodies() const;
  [[nodiscard]] Pose pose(int body) const override;
  [[nodiscard]] Twist twist(int body) const override;
  /// Kinetic energy of translation and rotation [J].
  [[nodiscard]] double kinetic_energy(int body) const;
  [[nodiscard]] std::vector<Contact> contacts() const override;
  [[nodiscard]] double time() const;
  [[nodiscard]] const WorldOptions& options() const;

 private:
  struct Bullet;
  std::unique_ptr<Bullet> bullet_;
};

}  // namespace stonestack::physics
