#include "stacking/device_tape.hpp"

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;

constexpr const char* kTapeSchema = "stonestack.inputs/1";
constexpr const char* kAnswers = "/answers.jsonl";
constexpr std::size_t kMaxAnswers = std::size_t{1} << 30;
constexpr int kMaxSide = 8192;  // pixels
constexpr std::size_t kMaxDepths = std::size_t{1} << 27;

/// JSON has no number that is none.
double number_of(const json& j) {
  return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>();
}

template <class Vector>
json numbers(const Vector& v) {
  json list = json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) list.push_back(v[i]);
  return list;
}
template <class Vector>
Vector vector_of(const json& j) {
  Vector v;
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = number_of(j.at(static_cast<std::size_t>(i)));
  return v;
}

json encode(const ArmState& s) {
  return {numbers(s.q),    numbers(s.qd), s.device_time, s.host_time,
          s.speed_scaling, s.can_move,    s.stop_reason};
}
json encode(const MotionResult& r) {
  return {static_cast<int>(r.status), numbers(r.q), r.force, r.reason, r.mean_force};
}
json encode(const GripperState& s) {
  return {s.opening, s.moving, s.object, s.fault, s.host_time};
}
json encode(const Wrench& w) {
  return {numbers(w.force), numbers(w.torque), w.device_time, w.host_time};
}
json encode(const CameraIntrinsics& c) {
  return {c.width, c.height, c.fx,   c.fy,   c.cx,  c.cy, static_cast<int>(c.distortion),
          c.k[0],  c.k[1],   c.k[2], c.k[3], c.k[4]};
}

ArmState arm_state_of(const json& j) {
  ArmState s;
  s.q = vector_of<Joints>(j.at(0));
  s.qd = vector_of<Joints>(j.at(1));
  s.device_time = number_of(j.at(2));
  s.host_time = number_of(j.at(3));
  s.speed_scaling = number_of(j.at(4));
  s.can_move = j.at(5).get<bool>();
  s.stop_reason = j.at(6).get<std::string>();
  return s;
}
MotionResult motion_result_of(const json& j) {
  MotionResult r;
  const int status = j.at(0).get<int>();
  require(status >= 0 && status <= static_cast<int>(MotionResult::Status::kDropped), "no status is ", status);
  r.status = static_cast<MotionResult::Status>(status);
  r.q = vector_of<Joints>(j.at(1));
  r.force = number_of(j.at(2));
  r.reason = j.at(3).get<std::string>();
  r.mean_force = number_of(j.at(4));
  return r;
}
GripperState gripper_state_of(const json& j) {
  GripperState s;
  s.opening = number_of(j.at(0));
  s.moving = j.at(1).get<bool>();
  s.object = j.at(2).get<bool>();
  s.fault = j.at(3).get<std::string>();
  s.host_time = number_of(j.at(4));
  return s;
}
Wrench wrench_of(const json& j) {
  Wrench w;
  w.force = vector_of<Eigen::Vector3d>(j.at(0));
  w.torque = vector_of<Eigen::Vector3d>(j.at(1));
  w.device_time = number_of(j.at(2));
  w.host_time = number_of(j.at(3));
  return w;
}
CameraIntrinsics intrinsics_of(const json& j) {
  CameraIntrinsics c;
  c.width = j.at(0).get<int>();
  c.height = j.at(1).get<int>();
  require(std::min(c.width, c.height) > 0 && std::max(c.width, c.height) <= kMaxSide, "an image has ",
          c.width, " x ", c.height, " pixels");
  c.fx = number_of(j.at(2));
  c.fy = number_of(j.at(3));
  c.cx = number_of(j.at(4));
  c.cy = number_of(j.at(5));
  c.distortion = static_cast<CameraIntrinsics::Distortion>(j.at(6).get<int>());
  for (std::size_t i = 0; i < 5; ++i) c.k[i] = number_of(j.at(7 + i));
  return c;
}

/// Throws where it is no answer to that call. `size` gives the bytes of a file of depths.
void check_answer(const std::string& call, const json& j,
                  const std::function<std::size_t(const std::string&)>& size) {
  if (j.is_object()) {
    (void)j.at("error").get<std::string>();
  } else if (call == "arm_state") {
    (void)arm_state_of(j);
  } else if (call == "follow" || call == "follow_guarded" || call == "carry") {
    (void)motion_result_of(j);
  } else if (call == "gripper_state" || call == "gripper_move") {
    (void)gripper_state_of(j);
  } else if (call == "force_read") {
    (void)wrench_of(j);
  } else if (call == "clock") {
    (void)number_of(j);
  } else if (call == "capture") {
    (void)j.at(0).get<long>();
    for (const std::size_t time : {1U, 2U}) (void)number_of(j.at(time));
    const CameraIntrinsics camera = intrinsics_of(j.at(3));
    const auto name = j.at(4).get<std::string>();
    require(name.find('/') == std::string::npos, "'", name, "' lies in another folder");
    const std::size_t wanted = sizeof(float) * static_cast<std::size_t>(camera.width * camera.height);
    require(size(name) == wanted, name, " has ", size(name), " bytes, not ", wanted);
  }
}

/// The error whose text that is.
DeviceError device_error(const std::string& what) {
  const std::size_t first = what.find(": "), last = what.rfind("; ");
  if (first == std::string::npos || last == std::string::npos || last < first)
    return {"device", what, "see the record"};
  return {what.substr(0, first), what.substr(first + 2, last - first - 2), what.substr(last + 2)};
}

class WritingTape final : public DeviceTape {
 public:
  explicit WritingTape(const std::string& folder) : folder_(folder) {
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    out_.open(folder + kAnswers, std::ios::trunc);
    put(json{{"schema", kTapeSchema}});
  }
  json answer(const std::string& call, const Ask& ask) override {
    try {
      json value = ask();
      put(json{{call, value}});
      return value;
    } catch (const DeviceError& error) {
      put(json{{call, {{"error", error.what()}}}});
      throw;
    }
  }
  std::string keep(const std::vector<float>& depths) override {
    char name[32];
    std::snprintf(name, sizeof name, "depth-%03d.f32", ++images_);
    const std::string path = folder_ + "/" + name;
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(depths.data()),
               static_cast<std::streamsize>(depths.size() * sizeof(float)));
    if (!file) fail(path);
    return name;
  }
  std::vector<float> depths(const std::string&) override { return {}; }

 private:
  [[noreturn]] static void fail(const std::string& path) {
    throw FileError(path, concat("cannot be written: ", std::strerror(errno)), "check the disk");
  }
  void put(const json& line) {
    const std::scoped_lock lock(mutex_);
    out_ << line.dump() << '\n';
    if (!out_.flush()) fail(folder_ + kAnswers);
  }

  std::string folder_;
  std::ofstream out_;
  std::mutex mutex_;  // the arm moves in a thread of its own
  int images_ = 0;
};

}  // namespace

std::unique_ptr<DeviceTape> record_devices(const std::string& folder) {
  return std::make_unique<WritingTape>(folder);
}

RecordedTape::RecordedTape(const std::string& folder) : folder_(folder) {
  const std::string path = folder + kAnswers;
  std::istringstream lines(read_file(path, kMaxAnswers));
  std::string line;
  for (int number = 0; std::getline(lines, line); ++number) {
    if (lines.eof()) break;  // torn when the run was killed
    const json j = json::parse(line, nullptr, false);
    const bool good =
        j.is_object() && j.size() == 1 && (number > 0 || j.value("schema", std::string()) == kTapeSchema);
    if (!good)
      throw FileError(path, concat("line ", number + 1, " is no answer of a device"),
                      "give the folder of a run with run.save_states=true");
    if (number == 0) continue;
    try {
      check_answer(j.begin().key(), j.begin().value(), [&](const std::string& name) {
        std::error_code error;
        const auto bytes = std::filesystem::file_size(folder + "/" + name, error);
        return error ? std::size_t{0} : static_cast<std::size_t>(bytes);
      });
    } catch (const std::exception& problem) {
      throw FileError(path, concat("line ", number + 1, ": ", problem.what()),
                      "take the record as it was made");
    }
    answers_[j.begin().key()].push_back(j.begin().value());
  }
}

json RecordedTape::answer(const std::string& call, const Ask&) {
  const std::scoped_lock lock(mutex_);
  const std::vector<json>& all = answers_[call];
  std::size_t& next = given_[call];
  if (next >= all.size()) {
    if (!ran_out_ && at_end) at_end();
    ran_out_ = true;
    throw DeviceError("record", concat("has no further answer to ", call), "the run ended here");
  }
  const json& value = all[next++];
  if (value.is_object()) throw device_error(value.at("error").get<std::string>());
  return value;
}

std::string RecordedTape::keep(const std::vector<float>&) {
  return {};
}

std::vector<float> RecordedTape::depths(const std::string& name) {
  const std::string bytes = read_file(folder_ + "/" + name, kMaxDepths);
  std::vector<float> list(bytes.size() / sizeof(float));
  std::memcpy(list.data(), bytes.data(), list.size() * sizeof(float));
  return list;
}

struct TapedDevices::Devices {
  struct TapedArm final : Arm {
    TapedArm(Arm* to, DeviceTape& by) : arm(to), tape(by) {}
    ArmState state() override {
      return arm_state_of(tape.answer("arm_state", [this] { return encode(arm->state()); }));
    }
    MotionResult follow(const JointTrajectory& t) override {
      return motion_result_of(tape.answer("follow", [&] { return encode(arm->follow(t)); }));
    }
    MotionResult carry(const JointTrajectory& t) override {
      return motion_result_of(tape.answer("carry", [&] { return encode(arm->carry(t)); }));
    }
    MotionResult follow_guarded(const GuardedMotion& motion) override {
      return motion_result_of(
          tape.answer("follow_guarded", [&] { return encode(arm->follow_guarded(motion)); }));
    }
    void stop() override {
      (void)tape.answer("stop", [this] { return arm->stop(), json(true); });
    }
    void set_payload(double mass, const Eigen::Vector3d& p_F_com) override {
      (void)tape.answer("set_payload", [&] { return arm->set_payload(mass, p_F_com), json(true); });
    }
    Arm* arm;
    DeviceTape& tape;
  };
  struct TapedGripper final : Gripper {
    TapedGripper(Gripper* to, DeviceTape& by) : gripper(to), tape(by) {}
    GripperState state() override {
      return gripper_state_of(tape.answer("gripper_state", [this] { return encode(gripper->state()); }));
    }
    GripperState move(double opening, double speed, double force) override {
      return gripper_state_of(
          tape.answer("gripper_move", [&] { return encode(gripper->move(opening, speed, force)); }));
    }
    void spread(double spacing) override {
      (void)tape.answer("gripper_spread", [&] { return gripper->spread(spacing), json(true); });
    }
    Gripper* gripper;
    DeviceTape& tape;
  };
  struct TapedSensor final : ForceTorqueSensor {
    TapedSensor(ForceTorqueSensor* to, DeviceTape& by) : sensor(to), tape(by) {}
    Wrench read() override {
      return wrench_of(tape.answer("force_read", [this] { return encode(sensor->read()); }));
    }
    void zero() override {
      (void)tape.answer("force_zero", [this] { return sensor->zero(), json(true); });
    }
    ForceTorqueSensor* sensor;
    DeviceTape& tape;
  };
  struct TapedCamera final : DepthCamera {
    TapedCamera(DepthCamera* to, DeviceTape& by) : camera(to), tape(by) {}
    DepthFrame capture() override {
      DepthFrame frame;
      const json j = tape.answer("capture", [&] {
        frame = camera->capture();
        return json{frame.number, frame.device_time, frame.host_time, encode(frame.image.camera),
                    tape.keep(frame.image.z)};
      });
      if (!frame.image.z.empty()) return frame;
      frame.number = j.at(0).get<long>();
      frame.device_time = number_of(j.at(1));
      frame.host_time = number_of(j.at(2));
      frame.image.camera = intrinsics_of(j.at(3));
      frame.image.z = tape.depths(j.at(4).get<std::string>());
      return frame;
    }
    DepthCamera* camera;
    DeviceTape& tape;
  };
  struct TapedClock final : Clock {
    TapedClock(Clock* to, DeviceTape& by) : clock(to), tape(by) {}
    double now() const override {
      try {
        last = number_of(tape.answer("clock", [this] { return json(clock->now()); }));
      } catch (const DeviceError&) {  // the record is at its end
      }
      return last;
    }
    Clock* clock;
    DeviceTape& tape;
    mutable std::atomic<double> last = 0.0;
  };

  Devices(const Cell& cell, DeviceTape& tape)
      : layout(cell.layout),
        arm(&cell.arm, tape),
        gripper(&cell.gripper, tape),
        sensor(&cell.force_torque, tape),
        camera(&cell.camera, tape),
        clock(&cell.clock, tape) {}
  Devices(const CellLayout& known, RecordedTape& tape)
      : layout(known),
        arm(nullptr, tape),
        gripper(nullptr, tape),
        sensor(nullptr, tape),
        camera(nullptr, tape),
        clock(nullptr, tape) {}
  CellLayout layout;
  TapedArm arm;
  TapedGripper gripper;
  TapedSensor sensor;
  TapedCamera camera;
  TapedClock clock;
};

TapedDevices::TapedDevices(const Cell& cell, DeviceTape& tape)
    : devices_(std::make_unique<Devices>(cell, tape)) {}
TapedDevices::TapedDevices(const CellLayout& layout, RecordedTape& tape)
    : devices_(std::make_unique<Devices>(layout, tape)) {}
TapedDevices::~TapedDevices() = default;

Cell TapedDevices::cell() {
  Devices& d = *devices_;
  return {d.arm, d.gripper, d.sensor, d.camera, d.clock, d.layout};
}

}  // namespace stonestack::stacking
