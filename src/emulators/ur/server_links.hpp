#pragma once
#include "emulators/ur/rtde_session.hpp"
#include "emulators/ur/script_queue.hpp"
#include "emulators/ur/server_link.hpp"
#include "urscript/script_collector.hpp"

namespace stonestack::emulators {

/// Port 30004.
class RtdeLink final : public ServerLink {
 public:
  RtdeLink(TcpStream stream, UrController& controller, InputOwners& owners, int number);
  void after_step() override;

 protected:
  void receive(std::string_view bytes) override;

 private:
  RtdeSession session_;
  int packages_ = 0;
};

/// Ports 30001 to 30003 and, read-only, 30011 to 30013.
class ScriptLink final : public ServerLink {
 public:
  enum class Kind { kPrimary, kSecondary, kRealtime };
  /// Puts what it receives into the queue, under its number.
  ScriptLink(TcpStream stream, UrController& controller, ScriptQueue& queue, int number, Kind kind,
             bool read_only);
  void after_step() override;
  /// Messages go to primary clients only.
  void report(const ControllerEvent& event);
  /// The state of this step is sent, whenever the next one is due.
  void require_state() { state_required_ = true; }

 protected:
  void receive(std::string_view bytes) override;
  [[nodiscard]] bool has_enough() const override { return queue_->is_full(number_); }

 private:
  void take(const std::string& script);

  ScriptQueue* queue_;
  int number_;
  Kind kind_;
  bool read_only_;
  ScriptCollector collector_;
  double heard_ = 0.0;
  std::uint64_t next_state_;
  bool state_required_ = false;
};

/// Port 29999.
class DashboardLink final : public ServerLink {
 public:
  DashboardLink(TcpStream stream, UrController& controller);

 protected:
  void receive(std::string_view bytes) override;

 private:
  std::string line_;
};

}  // namespace stonestack::emulators
