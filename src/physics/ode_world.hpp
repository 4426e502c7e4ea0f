#pragma once
#include <memory>
#include <vector>

#include "physics/rigid_world.hpp"

namespace stonestack::physics {

/// Stones and boxes on a table (z = 0) in the Open Dynamics Engine, which shares nothing with `World` but the
/// scans: contacts of its own between the scans' vertices, edges and faces (physics/mesh_contact.hpp), an
/// exact solver (dWorldStep), friction pyramids of four sides whose axes follow the sliding, or where nothing
/// slides the weight. `WorldOptions::iterations` has no effect. Gaps and depths of up to 10 um are rest. A
/// table that is not plane is, under each stone, the plane that touches it there.
///
/// Friction is limited by the normal force that the same contact carried in the step before. ODE's own limit,
/// the normal force that there would be without any friction, serves new contacts only: it lets a ladder
/// slide that leans, and walls whose stones wedge each other.
///
/// ODE's own collider of triangle meshes is not used: of two flat faces it reports the crossing edges as
/// sideways contacts as deep as the faces are wide (13 to 42 mm for boxes that meet by 10 um).
class OdeWorld final : public RigidWorld {
 public:
  explicit OdeWorld(const WorldOptions& options);
  ~OdeWorld() override;

  int add_stone(std::shared_ptr<const ContactShape> shape, const Pose& T_W_O, bool fixed) override;
  void add_table(const TableSurface& table) override;
  int add_box(const Eigen::Vector3d& size, const Pose& T_W_box) override;
  void move_to(int body, const Pose& T_W_body) override;
  void place(int body, const Pose& T_W_body, const Twist& twist) override;
  void set_pair_friction(int a, int b, double friction) override;
  void set_pair_stiffness(int a, int b, double stiffness) override;
  void apply(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) override;
  void set_gravity(const Eigen::Vector3d& g_W) override;
  void step(double dt) override;

  [[nodiscard]] Pose pose(int body) const override;
  [[nodiscard]] Twist twist(int body) const override;
  [[nodiscard]] std::vector<Contact> contacts() const override;

 private:
  struct Ode;
  std::unique_ptr<Ode> ode_;
};

}  // namespace stonestack::physics
