// How time passes in the true world: which stones are stepped, what the gripper does to them and they to it.
#include <algorithm>
#include <cmath>

#include "simulation/constants.hpp"
#include "simulation/true_world.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kChunk = 0.010;          // s between two searches for near pairs
constexpr double kGripStep = 1.0 / 2000;  // s while a pad is at a stone: pads are stiff springs
// Pads are integrated explicitly, with their damping: stable as long as the damping of all of them takes less
// than this share of a stone's speed in a step. Light cartons between stiff pads were shaken by kilonewtons.
constexpr double kPadShare = 0.7;
constexpr double kFinestGripStep = 2e-5;  // s: of things lighter than 15 g between the stiffest pads of `lab`
constexpr double kRolling = 0.3;          // 1/s, angular damping: a rounded stone does not rock for ever
constexpr double kGripperReach = 0.020;   // m: a stone this near the gripper is in play
constexpr double kStoneReach = 0.005;
constexpr double kRestShift = 0.00002;    // m
constexpr double kRestTurn = 0.0002;      // rad
constexpr double kGripperFriction = 0.0;  // rigid parts slide; only pads grip, and what they feel is complete
constexpr double kPartStiffness = 1e5;    // N/m, of a rigid part of the gripper at each touch; design choice
constexpr double kDeepestPress = 0.003;   // m into the table
constexpr double kYieldTime = 0.020;      // s in which the arm gives way to a load: 12 kg on 33 kN/m
constexpr double kYieldSpeed = 0.1;       // m/s, at most; design choice
constexpr double kInertiaTime = 0.020;  // s, low pass of the acceleration that the wrist feels; design choice
constexpr double kKeptMoments = 0.5;    // s of load and motion that a late sensor may ask for
constexpr double kLost = 0.2;           // m below the table: it has fallen from it
constexpr double kArmMaxForce = 150.0;  // N on the gripper: where a UR's protective stop is by default

Twist twist_between(const Pose& from, const Pose& to, double seconds) {
  const Eigen::AngleAxisd turn(to.rotation() * from.rotation().transpose());
  return {(to.translation() - from.translation()) / seconds, turn.angle() * turn.axis() / seconds};
}

}  // namespace

void TrueWorld::prepare_engine(const std::vector<bool>& in_play, double step) {
  if (engine_ && engine_->in_play == in_play) {
    engine_->step = step;
    return;
  }
  engine_.emplace(Engine{make_world(engine_kind_, step, kIterations, kRolling, in_play), step, in_play, 0});
  const auto stones = static_cast<int>(present_.size());
  for (std::size_t b = 0; b < model_.boxes.size(); ++b) {
    const auto& box = model_.boxes[b];
    const int body = engine_->world->add_box(box.size, box_pose(model_, box, gripper_pose_));
    if (b == 0) engine_->first_box = body;
    for (int k = 0; k < stones; ++k) {
      engine_->world->set_pair_friction(k, body, kGripperFriction);
      engine_->world->set_pair_stiffness(k, body, kPartStiffness);
    }
  }
}

// A stone is in play if it moves, if the gripper is near it, or if such a stone is near it.
std::vector<bool> TrueWorld::stones_in_play(const GripperPose& next) const {
  std::vector<bool> in_play(present_.size(), false);
  std::vector<std::size_t> open;
  const auto enter = [&](std::size_t k) {
    if (in_play[k] || state(present_[k]).aside) return;
    in_play[k] = true;
    open.push_back(k);
  };
  for (std::size_t k = 0; k < present_.size(); ++k) {
    const StoneIndex i = present_[k];
    const double reach = at(shapes_, i)->radius + kGripperReach;
    const Eigen::Vector3d p = centre_of_mass(i);
    if (!rests(i) || distance_to_gripper(model_, gripper_pose_, p) < reach ||
        distance_to_gripper(model_, next, p) < reach)
      enter(k);
  }
  while (!open.empty()) {
    const StoneIndex i = present_[open.back()];
    open.pop_back();
    for (std::size_t k = 0; k < present_.size(); ++k) {
      const StoneIndex j = present_[k];
      const double gap =
          (centre_of_mass(i) - centre_of_mass(j)).norm() - at(shapes_, i)->radius - at(shapes_, j)->radius;
      if (gap < kStoneReach) enter(k);
    }
  }
  return in_play;
}

// Step in which all the pads of the gripper are stable against the lightest stone that one of them is near.
double TrueWorld::step_of_pads() {
  double step = kWorldStep;
  for (const StoneIndex i : present_)
    for (int f = 0; f < model_.fingers(); ++f) {
      PadContact& pad = state(i).pads[static_cast<std::size_t>(f)];
      if (!pad.near(pad_pose(model_, f, gripper_pose_), state(i).T_W_O)) continue;
      const double all = model_.fingers() * pad.damping();
      const double stable = kPadShare * at(shapes_, i)->mass.mass / all;
      step = std::min({step, kGripStep, std::max(stable, kFinestGripStep)});
    }
  return step;
}

void TrueWorld::press_pads(const GripperPose& next, double step) {
  pad_load_ = {};
  finger_force_ = {};
  for (std::size_t k = 0; k < present_.size(); ++k) {
    if (!engine_->in_play[k]) continue;
    auto& it = state(present_[k]);
    const Eigen::Vector3d p_W_M = centre_of_mass(present_[k]);
    for (int f = 0; f < model_.fingers(); ++f) {
      const Pose T_W_P = pad_pose(model_, f, gripper_pose_);
      if (!it.pads[static_cast<std::size_t>(f)].near(T_W_P, it.T_W_O)) continue;
      const MovingFrame pad{T_W_P, T_W_P.translation(),
                            twist_between(T_W_P, pad_pose(model_, f, next), step)};
      const PadLoad load = it.pads[static_cast<std::size_t>(f)].press(pad, {it.T_W_O, p_W_M, it.twist});
      engine_->world->apply(static_cast<int>(k), load.force, load.moment_about(p_W_M));
      pad_load_.add({-load.force, -load.moment});
      finger_force_[static_cast<std::size_t>(f)] += load.normal;
    }
  }
}

void TrueWorld::read_stones(double step) {
  for (std::size_t k = 0; k < present_.size(); ++k) {
    auto& it = state(present_[k]);
    it.rest += step;
    if (!engine_->in_play[k]) continue;
    it.T_W_O = engine_->world->pose(static_cast<int>(k));
    it.twist = engine_->world->twist(static_cast<int>(k));
    const auto moved = difference(it.T_W_O, it.T_W_O_rest);
    if (moved.translation > kRestShift || moved.angle > kRestTurn) {
      it.T_W_O_rest = it.T_W_O;
      it.rest = 0.0;
    }
  }
}

// Rigid parts of the gripper; what presses a finger outwards counts for its drive as the pad's force does.
GripperLoad TrueWorld::read_contacts(double step) {
  GripperLoad load;
  const Eigen::Vector3d x_W = gripper_pose_.T_W_T.linear().col(0);
  const auto add = [&](int body, const Eigen::Vector3d& p_W, const Eigen::Vector3d& force) {
    if (body < engine_->first_box) return;
    load.add(p_W, force);
    const auto& box = model_.boxes[static_cast<std::size_t>(body - engine_->first_box)];
    if (box.finger >= 0) finger_force_[static_cast<std::size_t>(box.finger)] += box.side * x_W.dot(force);
  };
  for (const auto& contact : engine_->world->contacts()) {
    const Eigen::Vector3d force = contact.impulse / step * contact.n_W;  // on `above`
    add(contact.above, contact.p_W, force);
    add(contact.below, contact.p_W, -force);
  }
  return load;
}

Eigen::Vector3d TrueWorld::corner_at_table() const {
  if (!scene_.table.shape()) return lowest_corner(model_, gripper_pose_);
  return lowest_corner(model_, gripper_pose_,
                       [this](const Eigen::Vector3d& p_W) { return scene_.table.height(p_W); });
}

GripperLoad TrueWorld::table_load() const {
  GripperLoad load;
  const Eigen::Vector3d corner = corner_at_table();
  const double height = corner.z() - scene_.table.height(corner);
  if (height < 0) load.add(corner, {0, 0, -kPartStiffness * height});
  return load;
}

// The gripper's next pose with the fingers where their drives bring them.
GripperPose TrueWorld::driven(GripperPose next, double seconds) {
  if (drives_)
    next.finger = next_finger_places(model_, *drives_, gripper_pose_.finger, finger_force_, seconds);
  return next;
}

// The load pushes the tool away from where a stiff arm would hold it.
GripperPose TrueWorld::yielded(GripperPose wanted) const {
  if (yield_.isZero(0.0)) return wanted;
  const Eigen::Vector3d turn = yield_.tail<3>();
  wanted.T_W_T.translation() += yield_.head<3>();
  if (const double angle = turn.norm(); angle > 0)
    wanted.T_W_T.linear() = Eigen::AngleAxisd(angle, turn / angle) * wanted.T_W_T.rotation();
  return wanted;
}

void TrueWorld::yield_to(const GripperLoad& load, double seconds) {
  if (compliance_.isZero(0.0)) return;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << load.force, load.moment - gripper_pose_.T_W_T.translation().cross(load.force);
  // Beyond it the arm stops anyway.
  if (const double force = load.force.norm(); force > kArmMaxForce) wrench *= kArmMaxForce / force;
  Eigen::Matrix<double, 6, 1> change =
      (1.0 - std::exp(-seconds / kYieldTime)) * (compliance_ * wrench - yield_);
  if (const double shift = change.head<3>().norm(); shift > kYieldSpeed * seconds)
    change *= kYieldSpeed * seconds / shift;
  yield_ += change;
}

void TrueWorld::remember(double seconds) {
  if (options_.force_delay <= 0.0 && !options_.gripper_inertia) return;
  const auto centre = [&](const Pose& T_W_T) -> Eigen::Vector3d {
    return T_W_T * gripper_centre(model_.gripper);
  };
  GripperMoment now{time_, load_, gripper_pose_.T_W_T, Eigen::Vector3d::Zero()};
  if (!moments_.empty() && seconds > 0) {
    const GripperMoment& last = moments_.back();
    const Eigen::Vector3d v_W = (centre(now.T_W_T) - centre(last.T_W_T)) / seconds;
    const double share = 1.0 - std::exp(-seconds / kInertiaTime);
    now.a_W = last.a_W + share * ((v_W - v_W_) / seconds - last.a_W);
    v_W_ = v_W;
  }
  moments_.push_back(now);
  while (moments_.front().time < time_ - kKeptMoments) moments_.pop_front();
}

GripperMoment TrueWorld::moment_before(double delay) const {
  if (moments_.empty()) return {time_, load_, gripper_pose_.T_W_T, Eigen::Vector3d::Zero()};
  const auto later = std::find_if(moments_.begin(), moments_.end(), [&](const GripperMoment& moment) {
    return moment.time > time_ - delay + 1e-9;
  });
  return later == moments_.begin() ? *later : *std::prev(later);
}

// An uneven table has an edge; the plane z = 0 has none.
void TrueWorld::drop_what_fell() {
  for (const StoneIndex i : present_)
    if (!state(i).aside && centre_of_mass(i).z() < -kLost) put_away(i);
}

void TrueWorld::step_engine(const GripperPose& wanted) {
  const double step = engine_->step;
  commanded_ = wanted;
  const GripperPose next = driven(yielded(wanted), step);
  for (std::size_t f = 0; f < next.finger.size(); ++f) commanded_.finger[f] = next.finger[f];
  press_pads(next, step);
  for (std::size_t b = 0; b < model_.boxes.size(); ++b)
    engine_->world->move_to(engine_->first_box + static_cast<int>(b),
                            box_pose(model_, model_.boxes[b], next));
  engine_->world->step(step);
  gripper_pose_ = next;
  time_ += step;
  read_stones(step);
}

std::string TrueWorld::hard_contact() const {
  const Eigen::Vector3d corner = corner_at_table();
  const double height = corner.z() - scene_.table.height(corner);
  if (height < -kDeepestPress)
    return concat("the gripper is pressed ", -1e3 * height, " mm into the table at x ", corner.x(), " y ",
                  corner.y());
  if (felt_.norm() > kArmMaxForce)
    return concat("a force of ", felt_.norm(), " N on the gripper (limit ", kArmMaxForce,
                  " N): ", pad_load_.force.norm(), " N by the pads, ", table_load().force.norm(),
                  " N by the table, the rest by its rigid parts", hardest_contact());
  return {};
}

std::string TrueWorld::hardest_contact() const {
  const GripperPart* part = nullptr;
  Eigen::Vector3d p_W_hardest = Eigen::Vector3d::Zero();
  double hardest = 0.0;
  if (engine_)
    for (const auto& contact : engine_->world->contacts())
      for (const int body : {contact.above, contact.below})
        if (body >= engine_->first_box && contact.impulse > hardest) {
          part = &model_.boxes[static_cast<std::size_t>(body - engine_->first_box)];
          hardest = contact.impulse;
          p_W_hardest = contact.p_W;
        }
  if (part == nullptr) return {};
  return concat(", hardest by ",
                part->camera       ? "the camera"
                : part->finger < 0 ? "the palm"
                                   : "a finger",
                " at x ", p_W_hardest.x(), " y ", p_W_hardest.y(), " z ", p_W_hardest.z());
}

Progress TrueWorld::advance(double seconds, const GripperPath& path) {
  require(seconds >= 0 && std::isfinite(seconds), "time only passes forwards, asked for ", seconds, " s");
  Progress progress;
  while (progress.seconds < seconds) {
    GripperLoad sum;
    double weight = 0.0;
    const double chunk = std::min(kChunk, seconds - progress.seconds);
    const double end = progress.seconds + chunk;
    const GripperPose next = path(end);
    const auto in_play = stones_in_play(yielded(next));
    if (std::find(in_play.begin(), in_play.end(), true) == in_play.end()) {
      engine_.reset();
      finger_force_ = {};
      gripper_pose_ = driven(yielded(next), chunk);
      commanded_ = next;
      commanded_.finger = gripper_pose_.finger;
      time_ += chunk;
      yield_to(table_load(), chunk);
      sum.add(table_load(), chunk);
      weight += chunk;
      for (const StoneIndex i : present_) state(i).rest += chunk;
    } else {
      prepare_engine(in_play, step_of_pads());
      for (debt_ += chunk; debt_ >= 0.5 * engine_->step;) {
        debt_ -= engine_->step;
        step_engine(path(std::clamp(end - debt_, 0.0, seconds)));
        const GripperLoad contacts = read_contacts(engine_->step), table = table_load();
        sum.add(pad_load_, engine_->step);
        sum.add(contacts, engine_->step);
        sum.add(table, engine_->step);
        weight += engine_->step;
        GripperLoad all = pad_load_;
        all.add(contacts);
        all.add(table);
        yield_to(all, engine_->step);
      }
      if (scene_.table.shape()) drop_what_fell();
    }
    progress.seconds = end;
    if (weight > 0) load_ = {sum.force / weight, sum.moment / weight};
    remember(chunk);
    felt_ += std::min(1.0, chunk / kChunk) * (load_.force - felt_);
    progress.stopped = hard_contact();
    if (!progress.stopped.empty()) break;
  }
  return progress;
}

Progress TrueWorld::wait(double seconds) {
  const GripperPose held = commanded_;
  return advance(seconds, [&](double) { return held; });
}

}  // namespace stonestack::simulation
