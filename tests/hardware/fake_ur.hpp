#pragma once
#include <map>
#include <memory>
#include <mutex>

#include "hardware/fake_rtde.hpp"
#include "hardware/ur/ur_status.hpp"
#include "protocol/primary_wire.hpp"

namespace stonestack::hardware {

/// A UR controller that understands nothing: it shows fields over RTDE and changes them as the test asks
/// when a script arrives. Every millisecond it sends a state that is 8 ms later.
class FakeUr {
 public:
  /// State of the controller, and the events after some states.
  struct State {
    std::map<std::string, RtdeValue> fields;
    std::vector<std::pair<long, std::function<void(State&)>>> later;
    std::string to_send;  ///< bytes to send on the primary port
    void after(long states, std::function<void(State&)> change) {
      later.emplace_back(states, std::move(change));
    }
    template <class T>
    void set(const std::string& name, T value) {
      fields[name] = value;
    }
    void set_run(int run) { fields[reg(0)] = std::int32_t{run}; }
    void set_end(ScriptEnd end) { fields[reg(2)] = static_cast<std::int32_t>(end); }
    void set_paused() {
      fields["robot_status_bits"] = std::uint32_t{1};  // as the simulated controller clears it
      fields["runtime_state"] = std::uint32_t{4};
    }
    void set_running(bool running) {
      fields["robot_status_bits"] = std::uint32_t{running ? 3U : 1U};
      fields["runtime_state"] = std::uint32_t{running ? 2U : 1U};
    }
    [[nodiscard]] std::string reg(int i) const { return concat("output_int_register_", first + i); }
    int first = 24;
  };
  /// `run` is the number in the program's name.
  using OnScript = std::function<void(State&, const std::string& script, int run)>;

  explicit FakeUr(OnScript on_script, UrVersion version = {3, 15, 8, 106339})
      : version_(version),
        on_script_(std::move(on_script)),
        rtde_(std::make_unique<FakeRtde>([this](int) { return plan(); })),
        primary_(std::make_unique<FakeServer>([this](TcpStream& stream, int) { serve_scripts(stream); })),
        dashboard_([this](TcpStream& stream, int) { serve_dashboard(stream); }) {
    state_.first = first_register(version);
    for (const std::string& name : outputs()) state_.fields[name] = rtde_zero(find_rtde_output(name)->type);
    state_.set("robot_mode", std::int32_t{7});
    state_.set("safety_mode", std::int32_t{1});
    state_.set("safety_status", std::int32_t{1});
    state_.set("safety_status_bits", std::uint32_t{1});
    state_.set("speed_scaling", 1.0);
    state_.set("target_speed_fraction", 1.0);
    state_.set_running(false);
  }
  ~FakeUr() {
    silent_ = false;
    close_scripts();
    dashboard_.stop();
    rtde_.reset();
  }

  [[nodiscard]] UrArmOptions options() const {
    UrArmOptions o;
    o.address = "127.0.0.1";
    o.rtde_port = rtde_->endpoint().port;
    o.primary_port = primary_->port();
    o.secondary_port = o.realtime_port = 0;
    o.dashboard_port = dashboard_.port();
    o.start_timeout = 0.4;
    o.end_grace = 0.1;
    o.time_slack = 1.0;
    o.pause_limit = 20;  // s of the controller's clock
    o.stop_timeout = 0.5;
    o.rtde.retry_pause = 0.02;
    o.rtde.silent_after = 0.3;
    o.rtde.stale_after = 0.2;
    return o;
  }
  void change(const std::function<void(State&)>& change) {
    const std::lock_guard lock(mutex_);
    change(state_);
  }
  [[nodiscard]] std::string scripts() {
    const std::lock_guard lock(mutex_);
    return scripts_;
  }
  [[nodiscard]] int count(const std::string& text) {
    const std::string all = scripts();
    int n = 0;
    for (auto at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) ++n;
    return n;
  }
  /// Seconds of the controller's clock from one state to the next; they go on coming every millisecond.
  void set_period(double seconds) {
    const std::lock_guard lock(mutex_);
    period_ = seconds;
  }
  [[nodiscard]] int script_connections() const { return primary_->connections(); }
  /// No scripts any more: the connection is closed and others are refused.
  void close_scripts() {
    closing_scripts_ = true;
    primary_.reset();
  }
  /// Closes the script connection; others are accepted. Returns once it is closed.
  void drop_scripts() {
    dropping_scripts_ = true;
    while (dropping_scripts_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  /// No states any more on connections that stay open, until they are to come again.
  void set_silent(bool silent) { silent_ = silent; }
  [[nodiscard]] FakeRtde& rtde() { return *rtde_; }
  void set_remote(bool remote) { remote_ = remote; }

 private:
  [[nodiscard]] std::vector<std::string> outputs() const {
    const RtdeRecipe recipe = arm_recipe(version_);
    std::vector<std::string> names = {"timestamp"};
    for (const auto* list : {&recipe.required, &recipe.optional})
      names.insert(names.end(), list->begin(), list->end());
    return names;
  }

  FakeRtdePlan plan() {
    FakeRtdePlan plan;
    std::vector<std::string> types;
    for (const std::string& name : outputs())
      types.emplace_back(rtde_type_name(find_rtde_output(name)->type));
    const RtdeSetupReply inputs{1, {"INT32", "INT32", "DOUBLE", "DOUBLE", "DOUBLE"}};
    plan.replies = {{'V', {hex("00 04 56 01")}},
                    {'v', {encode(encode_control_version(version_))}},
                    {'O', {encode(encode_setup_reply(RtdeKind::kSetupOutputs, {1, types}, 2))}},
                    {'I', {encode(encode_setup_reply(RtdeKind::kSetupInputs, inputs, 2))}},
                    {'S', {hex("00 04 53 01")}}};
    plan.data = [this](long) { return next_state(); };
    plan.drop_after_data = true;
    return plan;
  }

  std::string next_state() {
    while (silent_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard lock(mutex_);
    auto due = std::move(state_.later);
    state_.later.clear();
    for (auto& [states, change] : due) {
      if (--states <= 0)
        change(state_);
      else
        state_.later.emplace_back(states, change);
    }
    if (std::exchange(drop_, false)) return {};
    time_ += period_;
    state_.set("timestamp", time_);
    RtdeData data{1, {}};
    for (const std::string& name : outputs()) data.values.push_back(state_.fields[name]);
    return encode(encode_data(data, 2, true));
  }

  void serve_scripts(TcpStream& stream) {
    std::string text;
    while (!closing_scripts_) {
      if (dropping_scripts_.exchange(false)) return;
      std::array<std::uint8_t, 65536> bytes{};
      const IoResult read = stream.read_some(bytes, Deadline::in(0.005));
      if (read.status == IoStatus::kClosed) return;
      text.append(reinterpret_cast<const char*>(bytes.data()), read.bytes);
      std::string to_send;
      {
        const std::lock_guard lock(mutex_);
        for (auto end = text.find("\nend\n"); end != std::string::npos; end = text.find("\nend\n")) {
          const std::string script = text.substr(0, end + 5);
          text.erase(0, end + 5);
          scripts_ += script;
          on_script_(state_, script, std::stoi(script.substr(script.find('_') + 1)));
        }
        to_send = std::exchange(state_.to_send, {});
      }
      if (!stream.write_all(to_send, Deadline::in(1.0))) return;
    }
  }

  void serve_dashboard(TcpStream& stream) {
    if (!stream.write_all(std::string_view("Connected: Universal Robots Dashboard Server\n"),
                          Deadline::in(1.0)))
      return;
    while (!dashboard_.ending()) {
      const LineResult line = stream.read_line(1024, Deadline::in(0.02));
      if (line.status == IoStatus::kClosed) return;
      std::string reply;
      if (line.line == "PolyscopeVersion") reply = "URSoftware " + to_string(version_) + " (x)\n";
      if (line.line == "is in remote control") reply = remote_ ? "true\n" : "false\n";
      if (!stream.write_all(reply, Deadline::in(1.0))) return;
    }
  }

 public:
  /// Closes the RTDE connection at the next state.
  void drop_rtde() {
    const std::lock_guard lock(mutex_);
    drop_ = true;
  }

 private:
  UrVersion version_;
  OnScript on_script_;
  std::mutex mutex_;
  State state_;
  std::string scripts_;
  double time_ = 100.0, period_ = 0.008;
  bool drop_ = false;
  std::atomic<bool> remote_{true}, silent_{false}, dropping_scripts_{false};
  std::unique_ptr<FakeRtde> rtde_;
  std::atomic<bool> closing_scripts_{false};
  std::unique_ptr<FakeServer> primary_;
  FakeServer dashboard_;
};

}  // namespace stonestack::hardware
