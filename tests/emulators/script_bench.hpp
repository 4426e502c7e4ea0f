#pragma once
#include <string>

#include "emulators/ur/controller.hpp"

namespace stonestack::emulators {

/// A controller without sockets over an ideal arm, in the middle of its reach.
struct ScriptBench {
  explicit ScriptBench(const std::string& version = "3.15.8.106339", const ControllerFaults& faults = {})
      : controller(options(version, faults), robot, plant) {}

  static UrServerOptions options(const std::string& version, const ControllerFaults& faults) {
    UrServerOptions options;
    options.version = version;
    options.faults = faults;
    return options;
  }
  static Joints start() {
    Joints q;
    q << 0.1, -1.3, 1.6, -1.8, -1.5, 0.2;
    return q;
  }

  void run(double seconds) {
    const auto steps = static_cast<int>(seconds / controller.period() + 0.5);
    for (int k = 0; k < steps; ++k) {
      controller.step();
      for (auto& event : controller.take_events()) note(event);
    }
  }
  /// Seconds until the program ended; fails after `max`.
  double run_to_end(double max = 30.0) {
    const double begin = controller.uptime();
    while (controller.runtime() != RuntimeState::kStopped && controller.uptime() < begin + max)
      run(controller.period());
    return controller.uptime() - begin;
  }
  /// Runs a script to its end; returns its textmsg output, lines joined by |.
  std::string output(const std::string& source, double max = 5.0) {
    texts.clear();
    exceptions.clear();
    controller.run_script(source);
    run(controller.period());
    run_to_end(max);
    return texts;
  }
  /// The last expression of the body, as textmsg prints it.
  std::string value(const std::string& expression) {
    return output("def v():\n textmsg(" + expression + ")\nend\n");
  }
  void note(const ControllerEvent& event) {
    using Kind = ControllerEvent::Kind;
    if (event.kind == Kind::kText) texts += (texts.empty() ? "" : "|") + event.text;
    if (event.kind == Kind::kKey) keys += event.title + ":" + event.text + "|";
    if (event.kind == Kind::kErrorCode) errors += "C" + std::to_string(event.code) + ":" + event.text + "|";
    if (event.kind == Kind::kRuntimeException)
      exceptions += std::to_string(event.line) + "," + std::to_string(event.column) + "," + event.text;
  }

  RobotModel robot = read_robot("ur10");
  IdealPlant plant{start()};
  UrController controller;
  std::string texts, keys, exceptions, errors;
};

}  // namespace stonestack::emulators
