#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/socket.hpp"
#include "protocol/rtde_wire.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/options.hpp"

namespace stonestack::hardware {

/// Fields that a client asks of the controller. `timestamp` is always added to the outputs, because START
/// needs an output and staleness needs a time.
struct RtdeRecipe {
  std::vector<std::string> required;             ///< outputs; a missing one is an error
  std::vector<std::string> optional;             ///< outputs that an older controller may not have
  std::vector<std::vector<std::string>> inputs;  ///< one recipe each
};
/// The recipe may depend on the controller, which is only known once connected.
using RtdeRecipeFor = std::function<RtdeRecipe(const UrVersion&)>;

struct RtdeOptions {
  double frequency = 0.0;        ///< 0 [Hz]: the control rate, 125 or 500
  double connect_timeout = 2.0;  ///< [s]
  double reply_timeout = 2.0;    ///< each step of the setup [s]
  double stale_after = 0.1;      ///< age at which a state is refused [s]
  double silent_after = 1.0;     ///< time [s] without a packet after which the link is set up anew
  int attempts = 3;              ///< of the first connection
  double retry_pause = 0.5;      ///< time [s] between attempts
  int in_use_attempts = 5;       ///< a dying connection frees its registers late
  double boot_timeout = 10.0;    ///< time for that [s]
};
[[nodiscard]] FieldList fields(RtdeOptions& options);

/// One state of the controller.
class RtdeSample {
 public:
  RtdeSample() = default;
  RtdeSample(std::shared_ptr<const std::vector<std::string>> names, std::vector<RtdeValue> values,
             double host_time);
  [[nodiscard]] double device_time() const { return get<double>("timestamp"); }
  [[nodiscard]] double host_time() const { return host_time_; }  ///< time by `host_seconds` [s]
  [[nodiscard]] bool has(std::string_view name) const { return find(name) != nullptr; }
  /// Throws InvalidArgument for a field that is not in the recipe or of another type.
  template <class T>
  [[nodiscard]] const T& get(std::string_view name) const {
    const RtdeValue* value = find(name);
    const T* typed = value == nullptr ? nullptr : std::get_if<T>(value);
    require(typed != nullptr, "no RTDE field '", name, "' of that type is subscribed");
    return *typed;
  }

 private:
  [[nodiscard]] const RtdeValue* find(std::string_view name) const;
  std::shared_ptr<const std::vector<std::string>> names_;
  std::vector<RtdeValue> values_;
  double host_time_ = 0.0;
};

/// Counts since the client was made.
struct RtdeCounts {
  long accepted = 0;
  long skipped = 0;  ///< steps that the controller left out because somebody was slow
  long refused = 0;  ///< packets that were malformed, repeated or not finite
  int sessions = 0;  ///< full setups; above 1: the link was lost and came back
};

/// Reads and writes a controller over RTDE. A thread of its own always drains the socket and keeps the newest
/// state; a lost or silent link is set up anew from the first packet on. Thread-safe.
class RtdeClient {
 public:
  /// Connects, sets up and waits until the controller has booted.
  /// @throws DeviceError: port closed, no answer, a required field missing (named), an input register owned
  /// by somebody else (named).
  RtdeClient(const Endpoint& controller, RtdeRecipeFor recipe, const RtdeOptions& options = {});
  ~RtdeClient();

  [[nodiscard]] UrVersion version() const;
  [[nodiscard]] int protocol() const;
  /// Optional outputs that this controller does not have.
  [[nodiscard]] std::vector<std::string> missing() const;
  /// The newest state.
  /// @throws DeviceError if it is stale, with the reason.
  [[nodiscard]] RtdeSample sample() const;
  /// A state received after the call; empty at the deadline.
  [[nodiscard]] std::optional<RtdeSample> wait_for_next(Deadline deadline) const;
  /// Writes the values of input recipe `recipe` (its place in RtdeRecipe::inputs).
  /// @throws InvalidArgument for a wrong number, type or a number that is not finite; DeviceError while the
  /// link is down.
  void send(std::size_t recipe, const std::vector<RtdeValue>& values);
  /// Takes the texts that the controller sent since the last call, at most the newest 64 texts.
  [[nodiscard]] std::vector<RtdeText> take_texts();
  [[nodiscard]] RtdeCounts counts() const;
  /// Host time of the samples: `host_seconds`.
  [[nodiscard]] double now() const;

 private:
  struct Link;
  std::unique_ptr<Link> link_;
};

}  // namespace stonestack::hardware
