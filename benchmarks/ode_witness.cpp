#include "ode_witness.hpp"
#include "physics/shape.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <mutex>

namespace stonestack::bench {
namespace {

constexpr int kFound = 256;            // contacts that ODE may report for a pair
constexpr std::size_t kContacts = 16;  // of these, the deepest and most spread: the solver is cubic in them

/// The world of one stack; frees all that it made.
class OdeWorld {
 public:
  explicit OdeWorld(double friction) : friction_(friction) {
    static std::once_flag once;
    std::call_once(once, [] { dInitODE2(0); });
    dAllocateODEDataForThread(dAllocateMaskAll);
    world_ = dWorldCreate();
    space_ = dSimpleSpaceCreate(nullptr);
    group_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, 0, 0, -9.81);
    dWorldSetCFM(world_, 1e-9);
    dWorldSetERP(world_, 0.2);
    dWorldSetContactMaxCorrectingVel(world_, 0.1);
    dCreatePlane(space_, 0, 0, 1, 0);
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;
  ~OdeWorld() {
    dJointGroupDestroy(group_);
    dSpaceDestroy(space_);
    for (Body& body : bodies_) dGeomTriMeshDataDestroy(body.data);
    dWorldDestroy(world_);
  }

  void add(const ContactShape& shape, const Pose& T_W_O) {
    Body body;
    const Eigen::Vector3d& p_O_M = shape.mass.p_O_M;
    for (const auto& v : shape.scan.vertices)
      for (int i = 0; i < 3; ++i) body.vertices.push_back(v[i] - p_O_M[i]);
    for (const auto& f : shape.scan.faces)
      for (int i = 0; i < 3; ++i) body.indices.push_back(static_cast<dTriIndex>(f[i]));
    bodies_.push_back(std::move(body));
    Body& kept = bodies_.back();
    kept.p_O_M = p_O_M;
    kept.data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(kept.data, kept.vertices.data(), 3 * sizeof(double),
                                static_cast<int>(kept.vertices.size() / 3), kept.indices.data(),
                                static_cast<int>(kept.indices.size()), 3 * sizeof(dTriIndex));
    kept.body = dBodyCreate(world_);
    dMass mass;
    const Eigen::Matrix3d& I = shape.mass.I_M;
    dMassSetParameters(&mass, static_cast<dReal>(shape.mass.mass), 0, 0, 0, static_cast<dReal>(I(0, 0)),
                       static_cast<dReal>(I(1, 1)), static_cast<dReal>(I(2, 2)), static_cast<dReal>(I(0, 1)),
                       static_cast<dReal>(I(0, 2)), static_cast<dReal>(I(1, 2)));
    dBodySetMass(kept.body, &mass);
    const Eigen::Vector3d p = T_W_O * p_O_M;
    const Eigen::Quaterniond q(T_W_O.linear());
    const dQuaternion turned{static_cast<dReal>(q.w()), static_cast<dReal>(q.x()), static_cast<dReal>(q.y()),
                             static_cast<dReal>(q.z())};
    dBodySetPosition(kept.body, static_cast<dReal>(p.x()), static_cast<dReal>(p.y()),
                     static_cast<dReal>(p.z()));
    dBodySetQuaternion(kept.body, turned);
    dGeomSetBody(dCreateTriMesh(space_, kept.data, nullptr, nullptr, nullptr), kept.body);
  }

  void step(double dt) {
    dSpaceCollide(space_, this, &OdeWorld::on_near);
    dWorldStep(world_, static_cast<dReal>(dt));
    dJointGroupEmpty(group_);
  }

  [[nodiscard]] Pose pose(std::size_t k) const {
    const dReal* p = dBodyGetPosition(bodies_[k].body);
    const dReal* q = dBodyGetQuaternion(bodies_[k].body);
    Pose T_W_M = Pose::Identity();
    T_W_M.translation() << p[0], p[1], p[2];
    T_W_M.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    return T_W_M * Eigen::Translation3d(-bodies_[k].p_O_M);
  }

 private:
  struct Body {
    std::vector<double> vertices;
    std::vector<dTriIndex> indices;
    Eigen::Vector3d p_O_M = Eigen::Vector3d::Zero();
    dTriMeshDataID data = nullptr;
    dBodyID body = nullptr;
  };

  static void on_near(void* self, dGeomID a, dGeomID b) { static_cast<OdeWorld*>(self)->touch(a, b); }

  void touch(dGeomID a, dGeomID b) {
    std::vector<dContactGeom> found(kFound);
    const int count = dCollide(a, b, kFound, found.data(), sizeof(dContactGeom));
    found.resize(static_cast<std::size_t>(std::max(count, 0)));
    for (const dContactGeom& geom : thinned(found)) {
      dContact contact{};
      contact.geom = geom;
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = static_cast<dReal>(friction_);
      dJointAttach(dJointCreateContact(world_, group_, &contact), dGeomGetBody(a), dGeomGetBody(b));
    }
  }

  /// The deepest, then those furthest from all that were taken.
  static std::vector<dContactGeom> thinned(const std::vector<dContactGeom>& found) {
    if (found.size() <= kContacts) return found;
    const auto at = [&](std::size_t k) {
      return Eigen::Vector3d(found[k].pos[0], found[k].pos[1], found[k].pos[2]);
    };
    std::vector<double> apart(found.size(), 1e9);
    std::size_t next = 0;
    for (std::size_t k = 1; k < found.size(); ++k)
      if (found[k].depth > found[next].depth) next = k;
    std::vector<dContactGeom> taken;
    while (taken.size() < kContacts) {
      taken.push_back(found[next]);
      const Eigen::Vector3d last = at(next);
      for (std::size_t k = 0; k < found.size(); ++k) apart[k] = std::min(apart[k], (at(k) - last).norm());
      next = static_cast<std::size_t>(std::max_element(apart.begin(), apart.end()) - apart.begin());
    }
    return taken;
  }

  double friction_;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID group_ = nullptr;
  std::vector<Body> bodies_;
};

}  // namespace

OdeVerdict stand_in_ode(const ShapeList& shapes, const Stack& stack, const OdeOptions& options) {
  OdeWorld world(options.friction);
  for (const PlacedStone& placed : stack.stones) world.add(*at(shapes, placed.stone), placed.T_W_O);
  OdeVerdict verdict;
  verdict.standing = static_cast<int>(stack.stones.size());
  for (double t = 0.0; t < options.seconds; t += options.step) {
    world.step(options.step);
    for (int k = 0; k < static_cast<int>(stack.stones.size()); ++k) {
      const PlacedStone& placed = stack.stones[static_cast<std::size_t>(k)];
      const Eigen::Vector3d& p_O_M = at(shapes, placed.stone)->mass.p_O_M;
      const Pose now = world.pose(static_cast<std::size_t>(k));
      const double shift = (now * p_O_M - placed.T_W_O * p_O_M).norm();
      const double turn = difference(placed.T_W_O, now).angle;
      verdict.shift = std::max(verdict.shift, shift);
      verdict.turn = std::max(verdict.turn, turn);
      if (shift > options.max_shift || turn > options.max_turn)
        verdict.standing = std::min(verdict.standing, k);
    }
    if (verdict.standing == 0) break;
  }
  return verdict;
}

}  // namespace stonestack::bench
