#include "physics/ode_world.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "physics/mesh_contact.hpp"
#include "physics/rigid_frame.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

constexpr std::size_t kContacts = 12;   // of a pair, the deepest and most spread: the solver is cubic in them
constexpr double kSoftness = 1e-7;      // ODE's CFM: redundant contacts share a load; 1 um/s at 10 N
constexpr double kUneven = 1e-7;        // m/s: by which the velocities that contacts ask for differ
constexpr double kOdeRecovery = 0.2;    // ODE's ERP: share of a depth that one step takes away
constexpr double kOdeFastest = 0.1;     // m/s, while depths are corrected
constexpr double kNear = 1e-5;          // m: gaps and depths up to this are rest: they neither close nor open
constexpr double kLayer = 2.0 * kNear;  // m: depths that ODE leaves alone
constexpr double kStays = 5e-6;   // m of depth that a new contact must have ahead of one of the last step
constexpr double kSlides = 1e-3;  // m/s: slower counts as at rest

using Vector = Eigen::Vector3d;

void start_ode() {
  static std::once_flag once;
  std::call_once(once, [] {
    dInitODE2(0);
    dSetMessageHandler([](int, const char*, va_list) {});
  });
}

Vector vector_of(const dReal* v) {
  return {v[0], v[1], v[2]};
}

Pose body_pose(dBodyID body) {
  const dReal* q = dBodyGetQuaternion(body);
  Pose T_W_M = Pose::Identity();
  T_W_M.translation() = vector_of(dBodyGetPosition(body));
  T_W_M.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  return T_W_M;
}

void put(dBodyID body, const Pose& T_W_M) {
  const Eigen::Quaterniond q(T_W_M.linear());
  const dQuaternion turned{q.w(), q.x(), q.y(), q.z()};
  dBodySetPosition(body, T_W_M.translation().x(), T_W_M.translation().y(), T_W_M.translation().z());
  dBodySetQuaternion(body, turned);
}

/// Number from 0 to 1 that belongs to a feature pair and a direction (splitmix64's finaliser).
double share_of(const std::array<int, 3>& features, unsigned direction) {
  std::uint64_t key = direction;
  for (const int feature : features) {
    key = (key ^ static_cast<std::uint64_t>(feature)) + 0x9e3779b97f4a7c15u;
    key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9u;
    key = (key ^ (key >> 27)) * 0x94d049bb133111ebu;
    key ^= key >> 31;
  }
  return static_cast<double>(key >> 11) * 0x1.0p-53;
}

/// Contacts of flat faces are redundant, and where two of them would open at the same moment ODE's solver
/// gives up and leaves the rest without force. Each asks for a velocity a little different, which decides.
void make_uneven(dSurfaceParameters& surface, const std::array<int, 3>& features) {
  surface.mode |= dContactMotionN | dContactMotion1 | dContactMotion2;
  surface.motionN = kUneven * share_of(features, 0);
  surface.motion1 = kUneven * (share_of(features, 1) - 0.5);
  surface.motion2 = kUneven * (share_of(features, 2) - 0.5);
}

void set_twist(dBodyID body, const Twist& twist) {
  dBodySetLinearVel(body, twist.v.x(), twist.v.y(), twist.v.z());
  dBodySetAngularVel(body, twist.w.x(), twist.w.y(), twist.w.z());
}

/// Features that carried a pair's contacts in the last step, with their normal forces [N].
using Carriers = std::map<std::array<int, 3>, double>;

/// The deepest, then those furthest from all that were taken; those of the last step have a lead, so that a
/// body at rest keeps its contacts.
std::vector<MeshTouch> thinned(const std::vector<MeshTouch>& found, const Carriers& before) {
  if (found.size() <= kContacts) return found;
  std::vector<double> apart(found.size(), 1e9), lead(found.size(), 1.0);
  std::size_t next = 0;
  double deepest = -1.0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const bool carried = before.contains(found[k].features);
    if (carried) lead[k] = 1.1;
    const double depth = -found[k].gap + (carried ? kStays : 0.0);
    if (depth > deepest) {
      deepest = depth;
      next = k;
    }
  }
  std::vector<MeshTouch> taken;
  while (taken.size() < kContacts) {
    taken.push_back(found[next]);
    double furthest = -1.0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      apart[k] = std::min(apart[k], lead[k] * (found[k].p - taken.back().p).norm());
      if (apart[k] <= furthest) continue;
      furthest = apart[k];
      next = k;
    }
  }
  return taken;
}

}  // namespace

struct OdeWorld::Ode {
  struct Body {
    std::shared_ptr<const ContactShape> stone;  ///< empty for a box
    ContactMesh mesh;                           ///< in M
    dBodyID body = nullptr;
    Vector p_O_M = Vector::Zero();
    bool led = false;    ///< moves as commanded or not at all
    bool moves = false;  ///< has a target for the next step
    Pose T_W_M_target = Pose::Identity();
  };
  /// A contact of the last step with the joint that carried it.
  struct Touch {
    Contact contact;
    std::array<int, 3> features{};
    dJointFeedback load{};
    /// Normal force of the step [N].
    [[nodiscard]] double normal_force() const { return std::max(0.0, vector_of(load.f1).dot(contact.n_W)); }
  };
  /// Memory of a pair of bodies from step to step.
  struct Meeting {
    MeshPair pair;
    Carriers carriers;
  };

  explicit Ode(const WorldOptions& o) : options(o), gravity(0, 0, -o.gravity) {
    start_ode();
    world = dWorldCreate();
    group = dJointGroupCreate(0);
    dWorldSetCFM(world, kSoftness);
    dWorldSetERP(world, kOdeRecovery);
    dWorldSetContactSurfaceLayer(world, kLayer);
  }
  Ode(const Ode&) = delete;
  Ode& operator=(const Ode&) = delete;
  ~Ode() {
    dJointGroupDestroy(group);
    dWorldDestroy(world);
  }

  Body& body(int index) {
    require(index >= 0 && index < static_cast<int>(bodies.size()) && bodies[static_cast<std::size_t>(index)],
            "no body ", index, "; there are ", bodies.size());
    return *bodies[static_cast<std::size_t>(index)];
  }
  int add(std::unique_ptr<Body> body, const MassProperties& mass, const Pose& T_W_O, bool fixed);
  void collide(double dt);
  void meet_table(int above, double dt);
  void meet(int above, int below, double dt);
  void join(int above, int below, const std::vector<MeshTouch>& found, double dt);
  [[nodiscard]] Vector friction_axis(const Touch& touch, const Body* above, const Body* below) const;
  [[nodiscard]] double friction_of(int a, int b) const {
    const auto found = frictions.find({std::min(a, b), std::max(a, b)});
    return found == frictions.end() ? options.friction : found->second;
  }
  void damp(double dt);
  void lead(double dt);
  void read_loads(double dt);

  WorldOptions options;
  Vector gravity;
  dWorldID world = nullptr;
  dJointGroupID group = nullptr;
  std::function<Plane(const Eigen::Vector2d&)> tangent;  ///< empty: z = 0
  std::map<std::pair<int, int>, double> frictions, stiffnesses;
  std::map<std::pair<int, int>, Meeting> meetings;
  std::vector<std::unique_ptr<Body>> bodies;    ///< null for a table
  std::vector<std::unique_ptr<Touch>> touches;  ///< ODE writes the loads into them
};

int OdeWorld::Ode::add(std::unique_ptr<Body> body, const MassProperties& mass, const Pose& T_W_O,
                       bool fixed) {
  require(is_valid(T_W_O), "the pose of body ", bodies.size(), " is not a rigid transform");
  body->p_O_M = mass.p_O_M;
  body->body = dBodyCreate(world);
  dMass inertia;
  const Eigen::Matrix3d& I = mass.I_M;
  dMassSetParameters(&inertia, mass.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  dBodySetMass(body->body, &inertia);
  dBodySetAutoDisableFlag(body->body, 0);  // what sleeps stands by decree
  dBodySetLinearDampingThreshold(body->body, 0);
  dBodySetAngularDampingThreshold(body->body, 0);
  put(body->body, T_W_O * Eigen::Translation3d(body->p_O_M));
  body->led = fixed;
  if (fixed) dBodySetKinematic(body->body);
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size()) - 1;
}

/// First axis of the friction pyramid: across the sliding its sides are too far out by up to 41 %, along it
/// they are where they belong. At rest it is the weight that would set it sliding.
Vector OdeWorld::Ode::friction_axis(const Touch& touch, const Body* above, const Body* below) const {
  const Vector& n = touch.contact.n_W;
  const auto velocity = [&](const Body* body) -> Vector {
    if (body == nullptr) return Vector::Zero();
    dVector3 v;
    const Vector& p = touch.contact.p_W;
    dBodyGetPointVel(body->body, p.x(), p.y(), p.z(), v);
    return vector_of(v);
  };
  Vector along = velocity(above) - velocity(below);
  along -= along.dot(n) * n;
  if (along.norm() < kSlides) along = gravity - gravity.dot(n) * n;
  return along.norm() < 1e-6 * std::max(1.0, gravity.norm()) ? n.unitOrthogonal() : along.normalized();
}

void OdeWorld::Ode::join(int above, int below, const std::vector<MeshTouch>& found, double dt) {
  const Body* upper = bodies[static_cast<std::size_t>(above)].get();
  const Body* lower = below == kTable ? nullptr : bodies[static_cast<std::size_t>(below)].get();
  const double friction = friction_of(above, below);
  const auto soft = stiffnesses.find({std::min(above, below), std::max(above, below)});
  const Carriers& before = meetings[{below, above}].carriers;
  for (const MeshTouch& at : thinned(found, before)) {
    auto touch = std::make_unique<Touch>();
    touch->contact = {below, above, at.p, at.n, at.gap, 0.0};
    touch->features = at.features;
    dContact contact{};
    std::copy(at.p.data(), at.p.data() + 3, contact.geom.pos);
    std::copy(at.n.data(), at.n.data() + 3, contact.geom.normal);
    contact.surface.mode = dContactFDir1;  // mu is a force [N], or with dContactApprox1 a coefficient
    if (soft != stiffnesses.end()) {       // an implicit spring
      contact.geom.depth = kLayer - at.gap;
      contact.surface.mode |= dContactSoftERP | dContactSoftCFM;
      contact.surface.soft_erp = 1.0;
      contact.surface.soft_cfm = 1.0 / (soft->second * dt);
    } else {
      contact.geom.depth = std::min(kNear - at.gap, kLayer + kOdeFastest * dt / kOdeRecovery);
    }
    if (const auto last = before.find(at.features); last != before.end()) {
      contact.surface.mu = friction * last->second;
    } else {
      contact.surface.mode |= dContactApprox1;
      contact.surface.mu = friction;
    }
    make_uneven(contact.surface, at.features);
    const Vector axis = friction_axis(*touch, upper, lower);
    std::copy(axis.data(), axis.data() + 3, contact.fdir1);
    const dJointID joint = dJointCreateContact(world, group, &contact);
    dJointAttach(joint, upper->body, lower == nullptr ? nullptr : lower->body);
    dJointSetFeedback(joint, &touch->load);
    touches.push_back(std::move(touch));
  }
}

void OdeWorld::Ode::meet_table(int above, double dt) {
  const Body& body = *bodies[static_cast<std::size_t>(above)];
  if (body.led || !body.stone) return;
  const Pose T_W_M = body_pose(body.body);
  const Plane plane = tangent ? tangent(T_W_M.translation().head<2>()) : Plane{Vector::UnitZ(), 0.0};
  join(above, kTable, plane_touches(body.mesh, T_W_M, plane.normal, plane.offset, kNear), dt);
}

void OdeWorld::Ode::meet(int above, int below, double dt) {
  const Body& upper = *bodies[static_cast<std::size_t>(above)];
  const Body& lower = *bodies[static_cast<std::size_t>(below)];
  if ((upper.led && lower.led) || (!upper.stone && !lower.stone)) return;
  const Pose T_W_upper = body_pose(upper.body), T_W_lower = body_pose(lower.body);
  const double reach = upper.mesh.radius + lower.mesh.radius + kNear;
  if ((T_W_upper.translation() - T_W_lower.translation()).norm() > reach) return;
  join(above, below,
       meetings[{below, above}].pair.touches(upper.mesh, lower.mesh, T_W_upper, T_W_lower, kNear), dt);
}

void OdeWorld::Ode::collide(double dt) {
  touches.clear();
  const int count = static_cast<int>(bodies.size());
  for (int above = 0; above < count; ++above) {
    if (!bodies[static_cast<std::size_t>(above)]) continue;
    meet_table(above, dt);
    for (int below = 0; below < above; ++below)
      if (bodies[static_cast<std::size_t>(below)]) meet(above, below, dt);
  }
}

/// Bullet's damping: a velocity loses the share 1 - (1 - damping)^dt.
void OdeWorld::Ode::damp(double dt) {
  const double linear = 1.0 - std::pow(1.0 - options.linear_damping, dt);
  const double angular = 1.0 - std::pow(1.0 - options.angular_damping, dt);
  for (auto& body : bodies)
    if (body && !body->led) dBodySetDamping(body->body, linear, angular);
}

void OdeWorld::Ode::lead(double dt) {
  for (auto& body : bodies) {
    if (!body || !body->led) continue;
    set_twist(body->body,
              body->moves ? velocity_between(body_pose(body->body), body->T_W_M_target, dt) : Twist{});
  }
}

void OdeWorld::Ode::read_loads(double dt) {
  for (auto& [pair, meeting] : meetings) meeting.carriers.clear();
  for (auto& touch : touches) {
    Contact& contact = touch->contact;
    contact.impulse = touch->normal_force() * dt;
    meetings[{contact.below, contact.above}].carriers[touch->features] = touch->normal_force();
  }
}

OdeWorld::OdeWorld(const WorldOptions& options) {
  require(options.friction > 0.0 && std::isfinite(options.friction), "friction must be positive, got ",
          options.friction);
  ode_ = std::make_unique<Ode>(options);
}
OdeWorld::~OdeWorld() = default;

int OdeWorld::add_stone(std::shared_ptr<const ContactShape> shape, const Pose& T_W_O, bool fixed) {
  require(shape != nullptr && !shape->scan.faces.empty(), "a stone needs a contact shape");
  auto body = std::make_unique<Ode::Body>();
  const MassProperties mass = shape->mass;
  body->mesh = make_contact_mesh(transformed(shape->scan, Pose(Eigen::Translation3d(-mass.p_O_M))));
  body->stone = std::move(shape);
  return ode_->add(std::move(body), mass, T_W_O, fixed);
}

void OdeWorld::add_table(const TableSurface& surface) {
  require(!ode_->tangent, "a world has one table");
  ode_->tangent = surface.tangent;
  ode_->bodies.push_back(nullptr);
}

int OdeWorld::add_box(const Eigen::Vector3d& size, const Pose& T_W_box) {
  require(size.minCoeff() > 0.0 && size.allFinite(), "a box needs positive sides, got ", size.transpose());
  auto body = std::make_unique<Ode::Body>();
  body->mesh = make_contact_mesh(make_box(size));
  MassProperties mass;
  mass.mass = 1.0;
  mass.p_O_M.setZero();
  mass.I_M.setIdentity();
  return ode_->add(std::move(body), mass, T_W_box, true);
}

void OdeWorld::move_to(int body, const Pose& T_W_body) {
  Ode::Body& b = ode_->body(body);
  require(b.led, "body ", body, " moves by itself; only boxes and fixed stones are led");
  require(is_valid(T_W_body), "the target of body ", body, " is not a rigid transform");
  b.moves = true;
  b.T_W_M_target = T_W_body * Eigen::Translation3d(b.p_O_M);
}

void OdeWorld::place(int body, const Pose& T_W_body, const Twist& twist) {
  Ode::Body& b = ode_->body(body);
  require(is_valid(T_W_body), "the pose of body ", body, " is not a rigid transform");
  put(b.body, T_W_body * Eigen::Translation3d(b.p_O_M));
  set_twist(b.body, twist);
  b.moves = false;
}

void OdeWorld::set_pair_friction(int a, int b, double friction) {
  require(friction >= 0.0 && std::isfinite(friction), "friction of bodies ", a, " and ", b,
          " must not be negative, got ", friction);
  ode_->frictions[{std::min(a, b), std::max(a, b)}] = friction;
}

void OdeWorld::set_pair_stiffness(int a, int b, double stiffness) {
  require(stiffness > 0.0 && std::isfinite(stiffness), "stiffness of bodies ", a, " and ", b,
          " must be positive, got ", stiffness, " N/m");
  ode_->stiffnesses[{std::min(a, b), std::max(a, b)}] = stiffness;
}

void OdeWorld::apply(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  const Ode::Body& b = ode_->body(body);
  dBodyAddForce(b.body, force.x(), force.y(), force.z());
  dBodyAddTorque(b.body, torque.x(), torque.y(), torque.z());
}

void OdeWorld::set_gravity(const Eigen::Vector3d& g_W) {
  ode_->gravity = g_W;
}

void OdeWorld::step(double dt) {
  require(dt > 0.0 && dt <= 0.1, "a step must be in (0, 0.1] s, got ", dt);
  dWorldSetGravity(ode_->world, ode_->gravity.x(), ode_->gravity.y(), ode_->gravity.z());
  ode_->damp(dt);
  ode_->lead(dt);
  ode_->collide(dt);
  dWorldStep(ode_->world, dt);
  ode_->read_loads(dt);
  dJointGroupEmpty(ode_->group);
  for (auto& body : ode_->bodies) {
    if (!body) continue;
    if (body->moves) put(body->body, body->T_W_M_target);
    body->moves = false;
    require(vector_of(dBodyGetPosition(body->body)).allFinite(), "ODE lost a body: it has no place any more");
  }
}

Pose OdeWorld::pose(int body) const {
  const Ode::Body& b = ode_->body(body);
  return body_pose(b.body) * Eigen::Translation3d(-b.p_O_M);
}

Twist OdeWorld::twist(int body) const {
  const Ode::Body& b = ode_->body(body);
  return {vector_of(dBodyGetLinearVel(b.body)), vector_of(dBodyGetAngularVel(b.body))};
}

std::vector<Contact> OdeWorld::contacts() const {
  std::vector<Contact> out;
  for (const auto& touch : ode_->touches) out.push_back(touch->contact);
  std::stable_sort(out.begin(), out.end(), [](const Contact& a, const Contact& b) {
    return std::pair(a.below, a.above) < std::pair(b.below, b.above);
  });
  return out;
}

}  // namespace stonestack::physics
