// Prints whether RTDE keeps up: samples, missed ones, when they arrive, and the CPU that either end takes.
// Without an address the simulated controller serves from a process of its own.
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <vector>

#include "bench.hpp"
#include "core/quantile.hpp"
#include "hardware/ur/ur_status.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/emulators/ur/ur_controller_server.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::bench {
namespace {

constexpr int kStandardPort = 30004;

struct RtdeBench {
  std::string address;
  int port = kStandardPort;
  double rate = 500.0, seconds = 60.0;
};

struct Findings {
  RtdeCounts counts;
  double seconds = 0.0;
  std::vector<double> lateness;  ///< of the step between two arrivals, s
  double client_cpu = 0.0;       ///< CPU time, s
  double server_cpu = -1.0;      ///< CPU time, s; negative: somebody else's server
};

/// A simulated e-Series controller in a child process, so that its CPU is not the client's.
class ServerProcess {
 public:
  ServerProcess() {
    if (::pipe(up_) < 0 || ::pipe(down_) < 0) throw Error("no pipes", ExitCode::kExecutionFailed);
    child_ = ::fork();
    if (child_ < 0) throw Error("no process for the server", ExitCode::kExecutionFailed);
    if (child_ == 0) serve();
    ::close(up_[1]);
    ::close(down_[0]);
    if (::read(up_[0], &port_, sizeof port_) != sizeof port_)
      throw Error("the server did not start", ExitCode::kExecutionFailed);
  }
  [[nodiscard]] int port() const { return port_; }
  /// Ends the server; the CPU seconds that it took.
  double end() {
    ::close(down_[1]);
    double cpu = -1.0;
    if (::read(up_[0], &cpu, sizeof cpu) != sizeof cpu) cpu = -1.0;
    ::close(up_[0]);
    ::waitpid(child_, nullptr, 0);
    return cpu;
  }

 private:
  [[noreturn]] void serve() {
    ::close(up_[0]);
    ::close(down_[1]);
    Joints q;
    q << 0.1, -1.3, 1.6, -1.8, -1.5, 0.2;
    UrServerOptions options;
    options.version = "5.12.2.1101534";
    IdealPlant plant(q);
    UrControllerServer server(options, read_robot("ur10"), plant);
    server.start();
    const double begin = processor_seconds();
    const int port = server.ports().rtde;
    char end = 0;
    bool sent = ::write(up_[1], &port, sizeof port) == sizeof port;
    while (sent && ::read(down_[0], &end, 1) > 0) continue;  // until the parent closes it
    const double cpu = processor_seconds() - begin;
    sent = ::write(up_[1], &cpu, sizeof cpu) == sizeof cpu;
    ::_exit(sent ? 0 : 1);
  }

  int up_[2] = {-1, -1}, down_[2] = {-1, -1};
  pid_t child_ = -1;
  int port_ = 0;
};

Findings listen(const RtdeBench& bench, const Endpoint& controller) {
  RtdeOptions options;
  options.frequency = bench.rate;
  const RtdeClient client(controller, arm_recipe, options);
  Findings found;
  found.lateness.reserve(static_cast<std::size_t>(bench.rate * bench.seconds) + 1);
  const RtdeCounts before = client.counts();
  const double cpu = processor_seconds();
  const Stopwatch watch;
  double last = -1.0;
  while (watch.seconds() < bench.seconds) {
    throw_if_interrupted();
    const auto sample = client.wait_for_next(Deadline::in(1.0));
    if (!sample) continue;
    if (last >= 0) found.lateness.push_back(std::abs(sample->host_time() - last - 1.0 / bench.rate));
    last = sample->host_time();
  }
  found.seconds = watch.seconds();
  found.client_cpu = processor_seconds() - cpu;
  found.counts = client.counts();
  found.counts.accepted -= before.accepted;
  found.counts.skipped -= before.skipped;
  return found;
}

void report(const Findings& f, Results& results) {
  const double share = 100.0 / f.seconds;
  const auto late_ms = [&](double part) { return 1e3 * quantile(f.lateness, part); };
  results.figures("rtde", {{"seconds", f.seconds, 1},
                           {"samples", f.counts.accepted},
                           {"missed", f.counts.skipped},
                           {"refused", f.counts.refused},
                           {"sessions", f.counts.sessions},
                           {"jitter_ms_median", late_ms(0.5), 3},
                           {"jitter_ms_p99", late_ms(0.99), 3},
                           {"jitter_ms_max", late_ms(1.0), 3},
                           {"client_cpu_percent", f.client_cpu * share, 1},
                           {"server_cpu_percent",
                            f.server_cpu >= 0 ? TableValue(f.server_cpu * share) : TableValue(), 1}});
}

void run(const RtdeBench& bench, Results& results) {
  const bool simulated = bench.address.empty();
  results.settings({{"rate_hz", bench.rate},
                    {"seconds", bench.seconds},
                    {"controller", simulated ? "simulated" : concat(bench.address, ':', bench.port)}});
  if (!simulated) return report(listen(bench, {bench.address, bench.port}), results);
  ServerProcess server;
  Findings found = listen(bench, {"127.0.0.1", server.port()});
  found.server_cpu = server.end();
  report(found, results);
}

}  // namespace

void add_rtde(CLI::App& app) {
  auto command = std::make_shared<RtdeBench>();
  CLI::App* sub = app.add_subcommand("rtde", "RTDE at full rate: missed samples, jitter, CPU of both ends");
  sub->add_option("--rate", command->rate, "Hz")->check(CLI::Range(1.0, 500.0))->capture_default_str();
  sub->add_option("--seconds", command->seconds, "How long")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  sub->add_option("--address", command->address,
                  "A controller; it is read from, nothing moves (default: simulated here)");
  sub->add_option("--port", command->port, "Its RTDE port")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  sub->footer("Example:\n  stonestack-bench rtde --seconds 600 --json");
  measure_by(*sub, [command](Results& results) { run(*command, results); });
}

}  // namespace stonestack::bench
