#include "physics/world.hpp"

#include <algorithm>
#include <cmath>

#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>

#include "physics/cone_solver.hpp"
#include "physics/rigid_frame.hpp"
#include "physics/surface_shape.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

constexpr int kTableGroup = 1, kStoneGroup = 2, kBoxGroup = 4;  // boxes meet stones only

/// Bullet's step without its clock, motion states and guesses about kinematic velocities.
class SteppedWorld : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
  void step_once(double dt) {
    internalSingleStepSimulation(dt);
    clearForces();
  }
};

btDefaultCollisionConstructionInfo small_pools() {
  btDefaultCollisionConstructionInfo info;  // 15 times cheaper to make than the default pools
  info.m_defaultMaxPersistentManifoldPoolSize = 1;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 128;
  info.m_customCollisionAlgorithmMaxElementSize = sizeof(TouchAlgorithm);
  return info;
}

}  // namespace

struct World::Bullet {
  struct Body {
    std::shared_ptr<const ContactShape> stone;  ///< empty for a box
    std::unique_ptr<SurfaceFeatures> box;
    std::unique_ptr<SurfaceShape> shape;
    std::unique_ptr<btRigidBody> rigid;
    Pose T_O_P = Pose::Identity();
    bool moves = false;  ///< has a target for the next step
    Pose T_W_target = Pose::Identity();
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
    Eigen::Vector3d weight_offset_P = Eigen::Vector3d::Zero();  ///< where the weight acts [m]
  };

  explicit Bullet(const WorldOptions& o)
      : options(o),
        configuration(small_pools()),
        dispatcher(&configuration),
        solver(&broadphase),
        world(&dispatcher, &broadphase, &solver, &configuration),
        factory(&rules),
        gravity(0, 0, -o.gravity) {
    rules.friction = o.friction;
    world.getSolverInfo().m_numIterations = o.iterations;
    dispatcher.registerCollisionCreateFunc(CUSTOM_CONCAVE_SHAPE_TYPE, CUSTOM_CONCAVE_SHAPE_TYPE, &factory);
    world.setGravity(btVector3(0, 0, 0));  // applied below, so that fixed bodies may be set free
    world.getSimulationIslandManager()->setSplitIslands(false);
    table = std::make_unique<btRigidBody>(0.0, nullptr, &table_shape);
    table->setUserIndex(kTable);
    world.addRigidBody(table.get(), kTableGroup, kStoneGroup);
  }
  ~Bullet() {
    for (auto& body : bodies) world.removeRigidBody(body->rigid.get());
    world.removeRigidBody(table.get());
  }
  Bullet(const Bullet&) = delete;
  Bullet& operator=(const Bullet&) = delete;

  Body& body(int index) {
    require(index >= 0 && index < static_cast<int>(bodies.size()), "no body ", index, "; there are ",
            bodies.size());
    return *bodies[static_cast<std::size_t>(index)];
  }
  /// The rule of a pair, to be changed.
  PairRule& rule(int a, int b) {
    if (uneven_table != kTable && std::min(a, b) == kTable) return rule(std::max(a, b), uneven_table);
    return rules.rules.try_emplace({std::min(a, b), std::max(a, b)}, rules.of(a, b)).first->second;
  }
  int add(std::unique_ptr<Body> body, double mass, const Eigen::Vector3d& moments, const Pose& T_W_O,
          bool fixed);
  void step(double dt);
  [[nodiscard]] static Pose pose(const Body& body) {
    return to_eigen(body.rigid->getWorldTransform()) * body.T_O_P.inverse();
  }

  WorldOptions options;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btDbvtBroadphase broadphase;
  ConeSolver solver;
  SteppedWorld world;
  PairRules rules;
  TouchAlgorithm::Factory factory;
  Eigen::Vector3d gravity;
  SurfaceShape table_shape;
  std::unique_ptr<btRigidBody> table;
  int uneven_table = kTable;  ///< body that is the table; kTable: the plane is
  std::vector<std::unique_ptr<Body>> bodies;
  double time = 0.0;
};

int World::Bullet::add(std::unique_ptr<Body> body, double mass, const Eigen::Vector3d& moments,
                       const Pose& T_W_O, bool fixed) {
  require(is_valid(T_W_O), "the pose of body ", bodies.size(), " is not a rigid transform");
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, body->shape.get(), to_bullet(moments));
  info.m_linearDamping = options.linear_damping;
  info.m_angularDamping = options.angular_damping;
  body->rigid = std::make_unique<btRigidBody>(info);
  btRigidBody& rigid = *body->rigid;
  rigid.setCenterOfMassTransform(to_bullet(T_W_O * body->T_O_P));
  rigid.setUserIndex(static_cast<int>(bodies.size()));
  rigid.setActivationState(DISABLE_DEACTIVATION);  // what sleeps stands by decree
  if (fixed) rigid.setCollisionFlags(rigid.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  const int group = body->stone ? kStoneGroup : kBoxGroup;
  world.addRigidBody(&rigid, group, body->stone ? kTableGroup | kStoneGroup | kBoxGroup : kStoneGroup);
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size()) - 1;
}

void World::Bullet::step(double dt) {
  require(dt > 0.0 && dt <= 0.1, "a step must be in (0, 0.1] s, got ", dt);
  for (auto& body : bodies) {
    btRigidBody& rigid = *body->rigid;
    if (rigid.isStaticOrKinematicObject()) {
      const Twist twist = body->moves ? velocity_between(to_eigen(rigid.getWorldTransform()),
                                                         body->T_W_target * body->T_O_P, dt)
                                      : Twist{};
      rigid.setLinearVelocity(to_bullet(twist.v));
      rigid.setAngularVelocity(to_bullet(twist.w));
    } else {
      const Eigen::Vector3d weight = gravity / rigid.getInvMass();
      const Eigen::Vector3d arm = to_eigen(rigid.getWorldTransform()).linear() * body->weight_offset_P;
      rigid.applyCentralForce(to_bullet(Eigen::Vector3d(body->force + weight)));
      rigid.applyTorque(to_bullet(Eigen::Vector3d(body->torque + arm.cross(weight))));
    }
    body->force.setZero();
    body->torque.setZero();
  }
  world.step_once(dt);
  for (auto& body : bodies) {
    if (body->moves) body->rigid->setCenterOfMassTransform(to_bullet(body->T_W_target * body->T_O_P));
    body->moves = false;
  }
  time += dt;
}

World::World(const WorldOptions& options) {
  require(options.friction > 0.0 && std::isfinite(options.friction), "friction must be positive, got ",
          options.friction);
  require(options.iterations >= 1, "the solver needs at least one iteration, got ", options.iterations);
  bullet_ = std::make_unique<Bullet>(options);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

int World::add_stone(std::shared_ptr<const ContactShape> shape, const Pose& T_W_O, bool fixed) {
  require(shape != nullptr && shape->features != nullptr, "a stone needs a contact shape");
  auto body = std::make_unique<Bullet::Body>();
  Eigen::Vector3d moments;
  body->T_O_P = principal_frame(shape->mass, &moments);
  body->shape =
      std::make_unique<SurfaceShape>(Surface{shape->features.get(), &shape->distance, {}}, body->T_O_P);
  const double mass = shape->mass.mass;
  body->stone = std::move(shape);
  return bullet_->add(std::move(body), mass, moments, T_W_O, fixed);
}

void World::add_table(const TableSurface& surface) {
  require(bullet_->uneven_table == kTable, "a world has one table");
  const int table = add_stone(surface.shape, Pose::Identity(), true);
  for (int k = 0; k < table; ++k) bullet_->rule(kTable, k).touches = false;
  bullet_->uneven_table = table;
}

int World::add_box(const Eigen::Vector3d& size, const Pose& T_W_box) {
  require(size.minCoeff() > 0.0 && size.allFinite(), "a box needs positive sides, got ", size.transpose());
  auto body = std::make_unique<Bullet::Body>();
  body->box = std::make_unique<SurfaceFeatures>(surface_features(make_box(size)));
  body->shape =
      std::make_unique<SurfaceShape>(Surface{body->box.get(), nullptr, 0.5 * size}, Pose::Identity());
  const int added = bullet_->add(std::move(body), 1.0, Eigen::Vector3d::Ones(), T_W_box, true);
  if (bullet_->uneven_table != kTable) bullet_->rule(bullet_->uneven_table, added).touches = false;
  return added;
}

void World::move_to(int body, const Pose& T_W_body) {
  Bullet::Body& b = bullet_->body(body);
  require(b.rigid->isStaticOrKinematicObject(), "body ", body,
          " moves by itself; only boxes and fixed stones are led");
  require(is_valid(T_W_body), "the target of body ", body, " is not a rigid transform");
  b.moves = true;
  b.T_W_target = T_W_body;
}

void World::place(int body, const Pose& T_W_body, const Twist& twist) {
  Bullet::Body& b = bullet_->body(body);
  require(is_valid(T_W_body), "the pose of body ", body, " is not a rigid transform");
  b.rigid->setCenterOfMassTransform(to_bullet(T_W_body * b.T_O_P));
  b.rigid->setLinearVelocity(to_bullet(twist.v));
  b.rigid->setAngularVelocity(to_bullet(twist.w));
  b.moves = false;
}

void World::set_fixed(int body, bool fixed) {
  Bullet::Body& b = bullet_->body(body);
  require(fixed || b.stone, "body ", body, " is a box; boxes only move as commanded");
  const int flag = btCollisionObject::CF_KINEMATIC_OBJECT;
  const int flags = b.rigid->getCollisionFlags();
  b.rigid->setCollisionFlags(fixed ? flags | flag : flags & ~flag);
  b.rigid->setLinearVelocity({0, 0, 0});
  b.rigid->setAngularVelocity({0, 0, 0});
  b.moves = false;
}

void World::set_pair_friction(int a, int b, double friction) {
  require(friction >= 0.0 && std::isfinite(friction), "friction of bodies ", a, " and ", b,
          " must not be negative, got ", friction);
  bullet_->rule(a, b).friction = friction;
}

void World::set_pair_stiffness(int a, int b, double stiffness) {
  require(stiffness > 0.0 && std::isfinite(stiffness), "stiffness of bodies ", a, " and ", b,
          " must be positive, got ", stiffness, " N/m");
  bullet_->rule(a, b).stiffness = stiffness;
}

void World::set_contact(int a, int b, bool enabled) {
  bullet_->rule(a, b).touches = enabled;
}

void World::apply(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  Bullet::Body& b = bullet_->body(body);
  b.force += force;
  b.torque += torque;
}

void World::set_gravity(const Eigen::Vector3d& g_W) {
  bullet_->gravity = g_W;
}

void World::set_weight_offset(int body, const Eigen::Vector3d& offset_O) {
  require(offset_O.allFinite(), "the weight of body ", body, " cannot act at ", offset_O.transpose());
  Bullet::Body& b = bullet_->body(body);
  b.weight_offset_P = b.T_O_P.linear().transpose() * offset_O;
}

void World::step() {
  bullet_->step(bullet_->options.step);
}
void World::step(double dt) {
  bullet_->step(dt);
}
void World::run(double seconds) {
  const long steps = std::max(1L, std::lround(seconds / bullet_->options.step));
  for (long i = 0; i < steps; ++i) step();
}

int World::bodies() const {
  return static_cast<int>(bullet_->bodies.size());
}
Pose World::pose(int body) const {
  return Bullet::pose(bullet_->body(body));
}

Twist World::twist(int body) const {
  const btRigidBody& rigid = *bullet_->body(body).rigid;
  return {to_eigen(rigid.getLinearVelocity()), to_eigen(rigid.getAngularVelocity())};
}

double World::kinetic_energy(int body) const {
  const Bullet::Body& b = bullet_->body(body);
  if (!b.stone) return 0.0;
  const Twist t = twist(body);
  const Eigen::Vector3d w_O = pose(body).linear().transpose() * t.w;
  return 0.5 * b.stone->mass.mass * t.v.squaredNorm() + 0.5 * w_O.dot(b.stone->mass.I_M * w_O);
}

std::vector<Contact> World::contacts() const {
  std::vector<Contact> out;
  const btBroadphasePairArray& pairs =
      bullet_->broadphase.getOverlappingPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    auto* algorithm = static_cast<TouchAlgorithm*>(pairs[i].m_algorithm);
    if (!algorithm) continue;
    const int below = algorithm->b()->getUserIndex(), above = algorithm->a()->getUserIndex();
    const bool on_table = bullet_->uneven_table != kTable && above == bullet_->uneven_table;
    for (const Touch& t : algorithm->touches()) {
      if (t.gap > bullet_->options.contact_gap) continue;
      if (on_table)
        out.push_back({kTable, below, t.p_W, -t.n_W, t.gap, t.impulse});
      else
        out.push_back({below, above, t.p_W, t.n_W, t.gap, t.impulse});
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const Contact& a, const Contact& b) {
    return std::pair(a.below, a.above) < std::pair(b.below, b.above);
  });
  return out;
}

double World::time() const {
  return bullet_->time;
}
const WorldOptions& World::options() const {
  return bullet_->options;
}

}  // namespace stonestack::physics
