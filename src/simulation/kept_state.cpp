// What of world and devices is kept for a process that goes on with the cell: everything that is not drawn
// from the seed again.
#include <array>
#include <bit>
#include <nlohmann/json.hpp>

#include "simulation/simulated_devices.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

using nlohmann::json;
using RandomState = std::array<std::uint64_t, 4>;

template <class Vector>
json numbers_of(const Vector& v) {
  json list = json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) list.push_back(v.data()[i]);
  return list;
}
template <class Vector>
Vector vector_from(const json& list) {
  Vector v;
  require(list.size() == static_cast<std::size_t>(v.size()), "a vector of ", v.size(), " numbers has ",
          list.size());
  for (Eigen::Index i = 0; i < v.size(); ++i)
    v.data()[i] = list.at(static_cast<std::size_t>(i)).get<double>();
  return v;
}

/// Rotation and translation as they are: a quaternion would round them.
json kept_pose(const Pose& pose) {
  return numbers_of(Eigen::Matrix<double, 3, 4>(pose.matrix().topRows<3>()));
}
Pose pose_from(const json& list) {
  Pose pose = Pose::Identity();
  pose.matrix().topRows<3>() = vector_from<Eigen::Matrix<double, 3, 4>>(list);
  return pose;
}

json kept_gripper_pose(const GripperPose& pose) {
  return {{"T_W_T", kept_pose(pose.T_W_T)}, {"finger", pose.finger}, {"narrowed", pose.narrowed}};
}
GripperPose gripper_pose_from(const json& j) {
  return {pose_from(j.at("T_W_T")), j.at("finger").get<std::array<double, kFingers>>(),
          j.at("narrowed").get<double>()};
}

json kept_load(const GripperLoad& load) {
  return {numbers_of(load.force), numbers_of(load.moment)};
}
GripperLoad load_from(const json& j) {
  return {vector_from<Eigen::Vector3d>(j.at(0)), vector_from<Eigen::Vector3d>(j.at(1))};
}

json kept_random(const Random& random) {
  return std::bit_cast<RandomState>(random);
}
Random random_from(const json& j) {
  return std::bit_cast<Random>(j.get<RandomState>());
}

}  // namespace

json PadContact::kept() const {
  json list = json::array();
  for (const Bristle& b : bristles_)
    if (b.active) list.push_back({b.sample, b.rest, b.anchor.x(), b.anchor.y()});
  return list;
}

void PadContact::restore(const json& kept) {
  bristles_.clear();
  for (const json& b : kept) {
    const int sample = b.at(0).get<int>();
    require(sample >= 0 && static_cast<std::size_t>(sample) < shape_->samples.size(),
            "a stone has no sample ", sample);
    bristles_.push_back(
        {sample, true, b.at(1).get<double>(), {b.at(2).get<double>(), b.at(3).get<double>()}});
  }
  note_points();
  collected_ = touching_ = false;  // the next step finds the others
}

json TrueWorld::kept() const {
  json stones = json::array();
  for (const StoneIndex i : present_) {
    const StoneState& it = state(i);
    json pads = json::array();
    for (const PadContact& pad : it.pads) pads.push_back(pad.kept());
    stones.push_back({{"T_W_O", kept_pose(it.T_W_O)},
                      {"T_W_O_rest", kept_pose(it.T_W_O_rest)},
                      {"rest", it.rest},
                      {"aside", it.aside},
                      {"pads", pads}});
  }
  json drives = json::array();
  if (drives_)
    for (const FingerDriveState& d : *drives_)
      drives.push_back({d.target, d.speed, d.force, d.regrip, d.holding});
  return {{"time", time_},
          {"debt", debt_},
          {"stones", stones},
          {"gripper", kept_gripper_pose(gripper_pose_)},
          {"commanded", kept_gripper_pose(commanded_)},
          {"yield", numbers_of(yield_)},
          {"drives", drives},
          {"load", kept_load(load_)},
          {"pad_load", kept_load(pad_load_)},
          {"felt", numbers_of(felt_)},
          {"finger_force", finger_force_}};
}

void TrueWorld::restore(const json& kept) {
  const json& stones = kept.at("stones");
  require(stones.size() == present_.size(), "it has ", stones.size(), " stones, not ", present_.size());
  for (std::size_t k = 0; k < present_.size(); ++k) {
    StoneState& it = state(present_[k]);
    const json& stone = stones.at(k);
    it.T_W_O = pose_from(stone.at("T_W_O"));
    it.T_W_O_rest = pose_from(stone.at("T_W_O_rest"));
    it.twist = {};
    it.rest = stone.at("rest").get<double>();
    it.aside = stone.at("aside").get<bool>();
    for (std::size_t f = 0; f < it.pads.size(); ++f) it.pads[f].restore(stone.at("pads").at(f));
  }
  set_gripper_pose(gripper_pose_from(kept.at("gripper")));
  commanded_ = gripper_pose_from(kept.at("commanded"));
  yield_ = vector_from<Eigen::Matrix<double, 6, 1>>(kept.at("yield"));
  drives_.reset();
  if (const json& drives = kept.at("drives"); !drives.empty()) {
    drives_.emplace();
    for (std::size_t f = 0; f < drives_->size(); ++f) {
      const json& d = drives.at(f);
      (*drives_)[f] = {d.at(0).get<double>(), d.at(1).get<double>(), d.at(2).get<double>(),
                       d.at(3).get<bool>(), d.at(4).get<bool>()};
    }
  }
  load_ = load_from(kept.at("load"));
  pad_load_ = load_from(kept.at("pad_load"));
  felt_ = vector_from<Eigen::Vector3d>(kept.at("felt"));
  finger_force_ = kept.at("finger_force").get<std::array<double, kFingers>>();
  time_ = kept.at("time").get<double>();
  debt_ = kept.at("debt").get<double>();
}

json SimulatedArm::kept() const {
  return {{"q", numbers_of(q_)},
          {"output", numbers_of(backlash_.output())},
          {"jitter", numbers_of(jitter_)},
          {"random", kept_random(random_)}};
}

void SimulatedArm::restore(const json& kept) {
  q_ = vector_from<Joints>(kept.at("q"));
  backlash_.restore(vector_from<Joints>(kept.at("output")));
  jitter_ = vector_from<Joints>(kept.at("jitter"));
  random_ = random_from(kept.at("random"));
  world_->set_compliance(tool_compliance(mounting_, q_));
}

json SimulatedGripper::kept() const {
  return {{"object", object_}};
}

void SimulatedGripper::restore(const json& kept) {
  object_ = kept.at("object").get<bool>();
}

json SimulatedForceTorque::kept() const {
  return {{"zero_force", numbers_of(zero_.force)},
          {"zero_torque", numbers_of(zero_.torque)},
          {"last_time", last_time_},
          {"random", kept_random(random_)}};
}

void SimulatedForceTorque::restore(const json& kept) {
  zero_.force = vector_from<Eigen::Vector3d>(kept.at("zero_force"));
  zero_.torque = vector_from<Eigen::Vector3d>(kept.at("zero_torque"));
  last_time_ = kept.at("last_time").get<double>();
  random_ = random_from(kept.at("random"));
}

json SimulatedCamera::kept() const {
  return {{"number", number_}, {"random", kept_random(random_)}};
}

void SimulatedCamera::restore(const json& kept) {
  number_ = kept.at("number").get<long>();
  random_ = random_from(kept.at("random"));
}

}  // namespace stonestack::simulation
