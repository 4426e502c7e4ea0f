#include "kinematics/urdf.hpp"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>

#include "core/constants.hpp"
#include "kinematics/urdf_shapes.hpp"
#include "kinematics/xml_guard.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kUrdfLongest = 10.0;  // m: nothing on an arm is further away or larger
constexpr double kSlowest = 0.01;  // rad/s: slower than any arm is driven; a plan would take minutes a turn

/// Keeps the parser's complaints, so that they reach the user in one message and nothing else is written to
/// stderr.
class Complaints : public console_bridge::OutputHandler {
 public:
  Complaints() { console_bridge::useOutputHandler(this); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  ~Complaints() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    const std::string line = text.substr(0, text.find('\n'));
    if (first.empty())
      first = line;
    else if (where.empty() && line.find('[') != std::string::npos && line != first)
      where = line;  // a value's complaint is followed by one that names its joint or link
  }
  std::string first, where;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& text, const std::string& path) {
  static std::mutex one_at_a_time;  // the parser's message handler is one for the process
  const std::lock_guard lock(one_at_a_time);
  Complaints complaints;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& problem) {
    complaints.first = problem.what();
  }
  if (complaints.first.find("No root link") != std::string::npos)
    throw FileError(path, "has no root link: its joints form a loop",
                    "open the loop; 'base_link' is no joint's child");
  if (!complaints.first.empty() || !model) {
    const std::string where = complaints.where.empty() ? "" : " (" + complaints.where + ")";
    throw FileError(
        path, complaints.first.empty() ? "is not a URDF" : "is not a valid URDF: " + complaints.first + where,
        "give a URDF of a UR robot");
  }
  return model;
}

bool sane(double value, double max) {
  return std::isfinite(value) && std::abs(value) <= max;
}

/// A URDF that was parsed, with the checks that the parser leaves out.
class Chain {
 public:
  Chain(const urdf::ModelInterface& model, const std::string& path) : model_(model), path_(path) {
    check_tree();
    find_joints();
  }

  void fill(RobotModel& robot) const {
    robot.name = model_.getName();
    robot.acceleration.setConstant(1.4);
    Pose T_link_frame = Pose::Identity();  // from the last link frame of the model to the current URDF frame
    int count = 0;
    add_shapes("base_link", 0, T_link_frame, robot);
    for (const auto* joint : joints_) {
      T_link_frame = T_link_frame * pose(joint->parent_to_joint_origin_transform, joint->name);
      if (joint->type == urdf::Joint::REVOLUTE) {
        const Pose T_joint_axis = axis_pose(*joint);
        robot.T_parent_joint[static_cast<std::size_t>(count)] = T_link_frame * T_joint_axis;
        set_limits(*joint, count, robot);
        T_link_frame = T_joint_axis.inverse();
        ++count;
      }
      add_shapes(joint->child_link_name, count, T_link_frame, robot);
    }
    robot.T_6_F = T_link_frame;
    tidy_shapes(robot.capsules, moving_links(), path_);
  }

 private:
  [[nodiscard]] std::vector<std::string> moving_links() const {
    std::vector<std::string> names;
    for (const auto* joint : joints_)
      if (joint->type == urdf::Joint::REVOLUTE) names.push_back(joint->child_link_name);
    return names;
  }

  [[noreturn]] void refuse(const std::string& problem, const std::string& remedy) const {
    throw FileError(path_, problem, remedy);
  }

  /// One root, one parent for each link, every link reachable from the root: the parser accepts less.
  void check_tree() const {
    std::map<std::string, std::string> parent_joint;
    std::map<std::string, std::vector<std::string>> children;
    for (const auto& [name, joint] : model_.joints_) {
      const auto [other, fresh] = parent_joint.emplace(joint->child_link_name, name);
      if (!fresh)
        refuse(concat("link '", joint->child_link_name, "' has two parents, by joints '", other->second,
                      "' and '", name, "'"),
               "keep one of them");
      children[joint->parent_link_name].push_back(joint->child_link_name);
    }
    std::vector<std::string> reached;
    for (const auto& [name, link] : model_.links_)
      if (parent_joint.count(name) == 0) reached.push_back(name);
    if (reached.size() != 1) refuse(concat("has ", reached.size(), " root links"), "one is wanted");
    for (std::size_t i = 0; i < reached.size(); ++i)
      for (const auto& child : children[reached[i]]) reached.push_back(child);
    if (reached.size() != model_.links_.size()) {
      const std::set<std::string> seen(reached.begin(), reached.end());
      for (const auto& [name, link] : model_.links_)
        if (seen.count(name) == 0)
          refuse(concat("link '", name, "' is not reached from the root: its joints form a loop"),
                 "open the loop");
    }
    for (const auto& [name, link] : model_.links_) check_inertial(*link);
  }

  void check_inertial(const urdf::Link& link) const {
    if (!link.inertial) return;
    const auto& inertial = *link.inertial;
    const auto complain = [&](const std::string& what) {
      refuse(concat("link '", link.name, "' has ", what), "correct its <inertial>");
    };
    if (!sane(inertial.mass, 1e4) || inertial.mass < 0) complain(concat("mass ", inertial.mass, " kg"));
    const double diagonal[] = {inertial.ixx, inertial.iyy, inertial.izz};
    for (const double value : diagonal)
      if (!sane(value, 1e6) || value < 0) complain(concat("a moment of inertia of ", value, " kg m^2"));
    for (const double value : {inertial.ixy, inertial.ixz, inertial.iyz})
      if (!sane(value, 1e6)) complain(concat("a product of inertia of ", value, " kg m^2"));
    (void)pose(inertial.origin, link.name);
  }

  /// Joints from base_link to tool0. All movable joints of the file must be among them.
  void find_joints() {
    for (const char* name : {"base_link", "tool0"})
      if (!model_.getLink(name))
        refuse(concat("has no link '", name, "'"), "name the base 'base_link' and the flange 'tool0'");
    for (auto link = model_.getLink("tool0"); link->name != "base_link"; link = link->getParent()) {
      if (!link->parent_joint || !link->getParent())
        refuse("has no chain from 'base_link' to 'tool0'", "join them by joints");
      joints_.push_back(link->parent_joint.get());
    }
    std::reverse(joints_.begin(), joints_.end());
    const auto movable = [](const urdf::Joint& joint) { return joint.type != urdf::Joint::FIXED; };
    const auto in_chain = std::count_if(joints_.begin(), joints_.end(), [&](auto* j) { return movable(*j); });
    const auto in_file = std::count_if(model_.joints_.begin(), model_.joints_.end(),
                                       [&](const auto& entry) { return movable(*entry.second); });
    if (in_chain != 6 || in_file != 6)
      refuse(concat("has ", in_file, " movable joints, ", in_chain, " of them between base_link and tool0"),
             "a UR arm has six; describe the gripper elsewhere");
    for (const auto* joint : joints_) {
      if (joint->mimic)
        refuse(concat("joint '", joint->name, "' mimics joint '", joint->mimic->joint_name, "'"),
               "an arm's joints turn on their own: drop its <mimic>");
      if (movable(*joint) && joint->type != urdf::Joint::REVOLUTE)
        refuse(concat("joint '", joint->name, "' is not of type revolute"),
               "make it revolute, with limits (a joint without end: one turn either way)");
    }
  }

  [[nodiscard]] Pose pose(const urdf::Pose& from, const std::string& where) const {
    const auto& p = from.position;
    const auto& r = from.rotation;
    if (!sane(p.x, kUrdfLongest) || !sane(p.y, kUrdfLongest) || !sane(p.z, kUrdfLongest))
      refuse(concat("'", where, "' has an origin at (", p.x, ", ", p.y, ", ", p.z, ") m"),
             concat("distances are finite and at most ", kUrdfLongest, " m"));
    const Eigen::Quaterniond q(r.w, r.x, r.y, r.z);
    if (!q.coeffs().allFinite() || std::abs(q.norm() - 1.0) > 1e-6)
      refuse(concat("'", where, "' has no valid rotation"), "give finite roll, pitch and yaw");
    Pose T = Pose::Identity();
    T.linear() = q.normalized().toRotationMatrix();
    T.translation() = Eigen::Vector3d(p.x, p.y, p.z);
    return T;
  }

  /// A frame whose z is the joint's axis.
  [[nodiscard]] Pose axis_pose(const urdf::Joint& joint) const {
    const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
    if (!axis.allFinite() || std::abs(axis.norm() - 1.0) > 1e-3)
      refuse(concat("joint '", joint.name, "' has the axis (", axis.transpose(), ")"), "give a unit vector");
    Pose T = Pose::Identity();
    T.linear() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis.normalized()).toRotationMatrix();
    return T;
  }

  void set_limits(const urdf::Joint& joint, int index, RobotModel& robot) const {
    const auto complain = [&](const std::string& what) {
      refuse(concat("joint '", joint.name, "' ", what), "give <limit lower upper velocity effort>");
    };
    if (!joint.limits) complain("has no limits");
    const auto& limit = *joint.limits;
    if (!std::isfinite(limit.lower) || !std::isfinite(limit.upper) || !(limit.lower < limit.upper))
      complain(concat("has the limits ", limit.lower, " to ", limit.upper, " rad"));
    if (!sane(limit.velocity, 1e3) || limit.velocity < kSlowest)
      complain(concat("has the velocity limit ", limit.velocity, " rad/s; an arm's is ", kSlowest,
                      " to 1000 rad/s"));
    if (!sane(limit.effort, 1e6) || limit.effort < 0)
      complain(concat("has the effort ", limit.effort, " Nm"));
    robot.lower[index] = std::max(limit.lower, -kTwoPi);
    robot.upper[index] = std::min(limit.upper, kTwoPi);
    if (!(robot.lower[index] < robot.upper[index]))
      complain(concat("has limits beyond one turn: ", limit.lower, " to ", limit.upper, " rad"));
    robot.velocity[index] = limit.velocity;
  }

  /// Collision shapes of a link and of what is fixed to it off the chain.
  void add_shapes(const std::string& name, int index, const Pose& T_link_frame, RobotModel& robot) const {
    const auto link = model_.getLink(name);
    for (const auto& collision : link->collision_array) {
      if (!collision || !collision->geometry) continue;
      const Pose T = T_link_frame * pose(collision->origin, name);
      for (const LinkCapsule& shape : covering(*collision->geometry, name, path_))
        robot.capsules.push_back({index, T * shape.a, T * shape.b, shape.radius});
    }
    for (const auto& joint : link->child_joints)
      if (std::find(joints_.begin(), joints_.end(), joint.get()) == joints_.end())
        add_shapes(joint->child_link_name, index,
                   T_link_frame * pose(joint->parent_to_joint_origin_transform, joint->name), robot);
  }

  const urdf::ModelInterface& model_;
  const std::string& path_;
  std::vector<const urdf::Joint*> joints_;
};

}  // namespace

RobotModel parse_urdf(const std::string& text, const std::string& path) {
  guard_xml(text, path);
  const auto model = parse(text, path);
  RobotModel robot;
  Chain(*model, path).fill(robot);
  return robot;
}

}  // namespace stonestack::kinematics
