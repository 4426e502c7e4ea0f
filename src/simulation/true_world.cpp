#include "simulation/true_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/shape_store.hpp"
#include "simulation/constants.hpp"
#include "simulation/true_shape.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kRestSeconds = 2.0;     // s: a stone that creeps is not taken for one at rest
constexpr double kShapeCell = 0.001;     // m, finer than the planner's
constexpr double kShapeBand = 0.006;     // m: half the planner's, because a finer grid costs more to fill
constexpr double kShapeSpacing = 0.002;  // m
constexpr double kAside = 50.0;          // m away: where stones wait that are not there

// The stone as it really is: a little heavier or lighter, its centre of mass a little off.
MassProperties true_mass(const MassProperties& assumed, const SimulationOptions& options, Random random) {
  MassProperties mass = assumed;
  const double factor = 1.0 + options.mass_error * std::clamp(random.normal(), -2.5, 2.5);
  mass.mass *= factor;
  mass.I_M *= factor;
  mass.p_O_M += options.com_error * std::cbrt(random.uniform()) * random.unit_vector();
  return mass;
}

// The rubber that grips it: what plans count on (GripperModel) is another matter.
PadOptions true_pad(const PadOptions& shape, const SimulationOptions& options, Random random) {
  PadOptions pad = shape;
  Random wear = Random::stream(static_cast<std::uint64_t>(options.seed), "true pad stiffness");
  const double factor = std::pow(options.pad_stiffness_spread, wear.uniform(-1.0, 1.0));
  pad.stiffness = options.pad_stiffness * factor;
  pad.shear = pad.stiffness / 3.0;
  const double spread = options.pad_friction_spread;
  pad.friction = std::max(0.05, options.pad_friction + random.uniform(-spread, spread));
  return pad;
}

/// Where the k-th stone waits while it is not there.
Pose away_pose(int k) {
  return make_pose(Eigen::Vector3d(kAside + static_cast<double>(k), kAside, 1.0));
}

}  // namespace

TrueWorld::TrueWorld(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
                     const GripperModel& gripper, const SimulationOptions& options, const TrueScene& scene)
    : options_(options),
      engine_kind_(engine_named(options.engine)),
      scene_(scene),
      model_(make_gripper_body(gripper, options.linkage)),
      present_(present) {
  std::sort(present_.begin(), present_.end());
  present_.erase(std::unique(present_.begin(), present_.end()), present_.end());
  const auto count = stones.size();
  shapes_.resize(count);
  states_.resize(count);
  const auto seed = static_cast<std::uint64_t>(options.seed);
  std::vector<Stone> real;
  for (const StoneIndex i : present_) {
    require(i.is_within(count), "there is no stone ", i, " among ", count);
    real.push_back(at(stones, i));
    real.back().mass =
        true_mass(real.back().mass, options, Random::stream(seed, "true mass " + real.back().name));
  }
  // A surface drawn beside its scan is this world's own and goes with it.
  const ShapeOptions fine{kShapeCell, kShapeBand, kShapeSpacing};
  const auto shapes =
      differs_from_scan(options) ? make_passing_shapes(real, fine) : make_contact_shapes(real, fine);
  for (std::size_t k = 0; k < present_.size(); ++k) {
    auto& it = at(states_, present_[k]);
    at(shapes_, present_[k]) = shapes[k];
    it.T_W_O = away_pose(static_cast<int>(k));
    const PadOptions pad =
        true_pad(model_.pad, options, Random::stream(seed, "true pad friction " + real[k].name));
    for (int f = 0; f < kFingers; ++f) it.pads.emplace_back(*shapes[k], pad);
  }
  Random known = Random::stream(seed, "true friction"), foreign = Random::stream(seed, "foreign friction");
  friction_.resize(count * (count + 1));
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j <= count; ++j) {
      const bool strange = is_foreign(StoneIndex(i)) || (j < count && is_foreign(StoneIndex(j)));
      const double mu = std::max(
          0.05, options.friction +
                    (strange ? foreign : known).uniform(-options.friction_spread, options.friction_spread));
      friction_[i * (count + 1) + j] = mu;
      if (j < count) friction_[j * (count + 1) + i] = mu;
    }
}

bool TrueWorld::is_foreign(StoneIndex stone) const {
  return stone.value() >= static_cast<int>(states_.size()) - scene_.foreign;
}

const TrueWorld::StoneState& TrueWorld::state(StoneIndex stone) const {
  require(stone.is_within(states_.size()) && at(shapes_, stone), "stone ", stone,
          " is not in the simulated cell");
  return at(states_, stone);
}

TrueWorld::StoneState& TrueWorld::state(StoneIndex stone) {
  return const_cast<StoneState&>(std::as_const(*this).state(stone));
}

Eigen::Vector3d TrueWorld::centre_of_mass(StoneIndex stone) const {
  return state(stone).T_W_O * at(shapes_, stone)->mass.p_O_M;
}

bool TrueWorld::rests(StoneIndex stone) const {
  return state(stone).rest >= kRestSeconds;
}

void TrueWorld::set_gripper_pose(const GripperPose& gripper_pose) {
  gripper_pose_ = commanded_ = gripper_pose;
  yield_.setZero();
  moments_.clear();
  v_W_.setZero();
  engine_.reset();
}

void TrueWorld::place(StoneIndex stone, const Pose& T_W_O) {
  auto& it = state(stone);
  it.T_W_O = it.T_W_O_rest = T_W_O;
  it.twist = {};
  it.rest = 0.0;
  it.aside = false;
  engine_.reset();
}

void TrueWorld::put_away(StoneIndex stone) {
  place(stone,
        away_pose(static_cast<int>(std::find(present_.begin(), present_.end(), stone) - present_.begin())));
  state(stone).aside = true;
}

std::unique_ptr<RigidWorld> TrueWorld::make_world(EngineKind engine, double step, int iterations,
                                                  double damping, const std::vector<bool>& in_play) const {
  WorldOptions options;
  options.friction = options_.friction;
  options.step = step;
  options.iterations = iterations;
  options.angular_damping = damping;
  auto world = make_rigid_world(engine, options);
  const auto count = states_.size();
  for (std::size_t k = 0; k < present_.size(); ++k) {
    const int body = world->add_stone(at(shapes_, present_[k]), state(present_[k]).T_W_O, !in_play[k]);
    if (in_play[k]) world->place(body, state(present_[k]).T_W_O, state(present_[k]).twist);
  }
  if (scene_.table.shape()) world->add_table(scene_.table.contact_surface());
  for (std::size_t k = 0; k < present_.size(); ++k) {
    const auto body = static_cast<int>(k);
    const std::size_t row = static_cast<std::size_t>(present_[k].value()) * (count + 1);
    world->set_pair_friction(kTable, body, friction_[row + count]);
    for (std::size_t other = 0; other < k; ++other)
      world->set_pair_friction(static_cast<int>(other), body,
                               friction_[row + static_cast<std::size_t>(present_[other].value())]);
  }
  return world;
}

std::unique_ptr<RigidWorld> TrueWorld::judge_world(double step, int iterations, EngineKind engine) const {
  std::vector<bool> in_play;
  for (const StoneIndex i : present_) in_play.push_back(!state(i).aside);
  return make_world(engine, step, iterations, 0.0, in_play);
}

std::vector<Contact> TrueWorld::contacts() const {
  const auto world = judge_world(kWorldStep, kIterations);
  world->step(kWorldStep);
  std::vector<Contact> found;
  for (Contact contact : world->contacts()) {
    if (contact.below != kTable) contact.below = present_[static_cast<std::size_t>(contact.below)].value();
    if (contact.above != kTable) contact.above = present_[static_cast<std::size_t>(contact.above)].value();
    found.push_back(contact);
  }
  return found;
}

}  // namespace stonestack::simulation
