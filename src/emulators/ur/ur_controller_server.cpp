#include "emulators/ur/ur_controller_server.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include "emulators/ur/server_links.hpp"
#include "protocol/primary_wire.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::emulators {
namespace {

using Steady = std::chrono::steady_clock;

constexpr double kRestartSeconds = 2.0;
constexpr auto kAcceptPeriod = std::chrono::milliseconds(4);
constexpr double kLongestLag = 0.25;  // s: what is lost beyond is not caught up

bool due(double& at, double now) {
  if (at < 0 || now < at) return false;
  at = -1.0;
  return true;
}

}  // namespace

struct UrControllerServer::Parts {
  UrServerOptions options;
  UrController controller;
  ScriptQueue queue;
  int next_link = 1;
  InputOwners owners;
  int next_session = 1;
  int script_links = 0;
  std::unique_ptr<ServerPort> rtde, dashboard;
  std::vector<std::unique_ptr<ServerPort>> scripts;  // 30001 .. 30003, 30011 .. 30013
  UrPorts ports;
  double reopen_rtde_at = -1.0;
  std::thread thread;
  std::atomic<bool> stopping{false};
  std::atomic<double> time{0.0};
  std::mutex mutex;
  std::vector<std::function<void()>> calls;  // from other threads

  Parts(const UrServerOptions& all, const RobotModel& robot, Plant& plant)
      : options(all), controller(all, robot, plant), queue(controller) {}

  [[nodiscard]] std::unique_ptr<ServerPort> open(int standard, ServerPort::MakeLink make) const;
  void open_all();
  void close_all();
  void loop();
  void turn(bool accept);
  void trigger_faults();
  void call(std::function<void()> what);
};

std::unique_ptr<ServerPort> UrControllerServer::Parts::open(int standard, ServerPort::MakeLink make) const {
  ListenOptions listen;
  listen.address = options.address;
  listen.port = options.standard_ports ? standard : 0;
  return std::make_unique<ServerPort>(listen, std::move(make));
}

void UrControllerServer::Parts::open_all() {
  const auto& faults = options.faults;
  ports = {};
  if (!faults.no_rtde) {
    rtde = open(30004, [this](TcpStream stream) {
      return std::make_unique<RtdeLink>(std::move(stream), controller, owners, next_session++);
    });
    ports.rtde = rtde->port();
  }
  if (!faults.no_dashboard && controller.version().major < 10) {
    dashboard = open(29999, [this](TcpStream stream) {
      return std::make_unique<DashboardLink>(std::move(stream), controller);
    });
    ports.dashboard = dashboard->port();
  }
  if (faults.no_script_ports) return;
  int* const numbers[] = {&ports.primary,           &ports.secondary,           &ports.realtime,
                          &ports.primary_read_only, &ports.secondary_read_only, &ports.realtime_read_only};
  for (int k = 0; k < 6; ++k) {
    const auto kind = static_cast<ScriptLink::Kind>(k % 3);
    const bool read_only = k >= 3;
    scripts.push_back(open(30001 + k % 3 + (read_only ? 10 : 0), [this, kind, read_only](TcpStream stream) {
      const bool reads = read_only || ++script_links <= controller.faults.read_only_links;
      return std::make_unique<ScriptLink>(std::move(stream), controller, queue, next_link++, kind, reads);
    }));
    *numbers[k] = scripts.back()->port();
  }
}

void UrControllerServer::Parts::close_all() {
  rtde.reset();
  dashboard.reset();
  scripts.clear();
}

void UrControllerServer::Parts::trigger_faults() {
  if (!rtde) return;
  auto& faults = controller.faults;
  const double now = controller.uptime();
  if (due(faults.drop_rtde_at, now)) rtde->mute_links();
  if (due(faults.close_rtde_at, now)) rtde->close_links();
  if (due(faults.restart_rtde_at, now)) {
    rtde->shut();
    reopen_rtde_at = now + kRestartSeconds;
  }
  if (due(reopen_rtde_at, now)) rtde->reopen();
}

void UrControllerServer::Parts::turn(bool accept) {
  std::vector<std::function<void()>> todo;
  {
    const std::lock_guard guard(mutex);
    std::swap(todo, calls);
  }
  for (const auto& call_it : todo) call_it();
  // RTDE last: a client that takes its command back by RTDE and sends a program then must not find the
  // program here before the command is gone.
  const auto each = [&](auto&& what) {
    for (auto& port : scripts) what(*port);
    if (dashboard) what(*dashboard);
    if (rtde) what(*rtde);
  };
  if (accept) each([](ServerPort& port) { port.accept(); });
  each([](ServerPort& port) { port.pump(); });
  queue.turn();
  controller.step();
  trigger_faults();
  const auto events = controller.take_events();
  const auto for_scripts = [&](auto&& what) {
    for (auto& port : scripts)
      for (auto& link : port->links()) what(static_cast<ScriptLink&>(*link));
  };
  // Who reads of a new safety mode finds it in the state that came before.
  if (std::any_of(events.begin(), events.end(), [](const ControllerEvent& event) {
        return event.kind == ControllerEvent::Kind::kSafetyMode;
      }))
    for_scripts([](ScriptLink& link) { link.require_state(); });
  each([](ServerPort& port) { port.after_step(); });
  for (const auto& event : events) for_scripts([&](ScriptLink& link) { link.report(event); });
  time = controller.uptime();
}

void UrControllerServer::Parts::loop() {
  const auto seconds = [](double s) {
    return std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(s));
  };
  const auto period = seconds(controller.period() / options.speed);
  auto next = Steady::now(), accepted = next - kAcceptPeriod;
  try {
    while (!stopping) {
      const bool accept = Steady::now() - accepted >= kAcceptPeriod;
      if (accept) accepted = Steady::now();
      turn(accept);
      next = std::max(next + period, Steady::now() - seconds(kLongestLag));
      std::this_thread::sleep_until(next);
    }
  } catch (const std::exception& error) {
    log_error(concat("simulated UR controller: ", error.what()));
  }
  close_all();
}

void UrControllerServer::Parts::call(std::function<void()> what) {
  const std::lock_guard guard(mutex);
  calls.push_back(std::move(what));
}

UrControllerServer::UrControllerServer(const UrServerOptions& options, const RobotModel& robot,
                                       Plant& plant) {
  require(options.speed > 0 && std::isfinite(options.speed), "time passes at a positive speed, got ",
          options.speed);
  require(is_loopback(options.address), "the simulated controller listens on 127.x.y.z, not on ",
          options.address);
  require(options.safety_checksum.empty() || parse_checksum(options.safety_checksum),
          "a safety configuration's checksum has eight hexadecimal digits, not '", options.safety_checksum,
          "'");
  parts_ = std::make_unique<Parts>(options, robot, plant);
}

UrControllerServer::~UrControllerServer() {
  stop();
}

void UrControllerServer::start() {
  stop();
  parts_->open_all();
  parts_->stopping = false;
  parts_->thread = std::thread([this] { parts_->loop(); });
}

void UrControllerServer::stop() {
  parts_->stopping = true;
  if (parts_->thread.joinable()) parts_->thread.join();
  parts_->close_all();
}

const UrPorts& UrControllerServer::ports() const {
  return parts_->ports;
}

void UrControllerServer::cut_rtde() {
  parts_->call([this] {
    if (parts_->rtde) parts_->rtde->close_links();
  });
}

void UrControllerServer::protective_stop(const std::string& reason) {
  constexpr int kCollision = 157;
  parts_->call([this, reason] { parts_->controller.protective_stop(kCollision, reason); });
}

void UrControllerServer::set_faults(const ControllerFaults& faults) {
  parts_->call([this, faults] {
    parts_->controller.faults = faults;
    parts_->controller.speed_slider = faults.speed_slider;
  });
}

double UrControllerServer::time() const {
  return parts_->time;
}

}  // namespace stonestack::emulators
