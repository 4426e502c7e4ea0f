#include "hardware/ur/primary_client.hpp"

#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

constexpr std::size_t kKept = 256, kChunk = 16384;
constexpr double kReadTurn = 1.0;     // s
constexpr long kStatesWithout = 3;    // states that show that a controller does not say something
constexpr int kRealtimePort = 30003;  // and its frames carry no type

void require_whole(const std::string& script) {
  require(!script.empty() && script.back() == '\n', "a program ends with a new line");
}

}  // namespace

struct PrimaryClient::Link {
  Link(std::string at, const PrimaryOptions& o) : address(std::move(at)), options(o) {
    require(!options.ports.empty(), "a script port is needed");
    connect(true);
  }
  ~Link() { disconnect(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  [[nodiscard]] Deadline make_deadline(bool interruptible) const {
    const Deadline deadline = Deadline::in(options.connect_timeout);
    return interruptible ? deadline.or_interrupt() : deadline;
  }

  /// A later connection may be for a stop, which Ctrl-C must not keep back.
  void connect(bool interruptible = false) {
    {
      const std::lock_guard lock(messages_mutex);
      odd.clear();
    }
    std::string problems;
    for (const int candidate : options.ports) try {
        stream = std::make_shared<TcpStream>(
            TcpStream::connect({address, candidate}, make_deadline(interruptible)));
        port = candidate;
        reader = std::thread([this, s = stream, speaks = candidate != kRealtimePort] { drain(*s, speaks); });
        return;
      } catch (const DeviceError& error) {
        problems += concat(problems.empty() ? "" : " | ", error.what());
      }
    throw DeviceError("UR script port at " + address, problems,
                      "switch the controller on, and enable the client interfaces in its security settings");
  }

  void disconnect() {
    if (stream) stream->shut();
    if (reader.joinable()) reader.join();
    stream.reset();
  }

  /// Listens until the connection ends; messages about programs are kept.
  void drain(TcpStream& from, bool speaks) {
    PrimaryStream parser;
    std::array<std::uint8_t, kChunk> bytes{};
    bool knows_version = false;
    try {
      while (!from.is_shut()) {
        const IoResult read = from.read_some(bytes, Deadline::in(kReadTurn));
        if (read.status == IoStatus::kClosed) break;
        parser.feed({reinterpret_cast<const char*>(bytes.data()), read.bytes});
        while (auto message = parser.next()) {
          knows_version = knows_version || message->kind == PrimaryMessage::Kind::kVersion;
          if (speaks) keep(std::move(*message));
        }
        if (speaks) keep(parser);
        note(knows_version || (speaks ? parser.states() : parser.passed_over()) > 0, parser.problem());
        if (!speaks || parser.problem().empty()) continue;
        log_warning(from.name() + ": out of step: " + parser.problem() +
                    "; connecting anew at the next script");
        break;
      }
    } catch (const Error& error) {
      log_debug(error.what());
    }
    from.shut();
    forget();
    note(false, "it closed the connection");
  }

  /// Another controller, or another configuration, may be on the next connection.
  void forget() {
    const std::lock_guard lock(messages_mutex);
    safety_checksum.reset();
    states = 0;
  }

  /// For `wait_until_heard`: is this a controller, or what else?
  void note(bool is_controller, const std::string& problem) {
    const std::lock_guard lock(messages_mutex);
    heard = heard || is_controller;
    if (odd.empty()) odd = problem;
    noted.notify_all();
  }

  void keep(PrimaryMessage message) {
    const std::lock_guard lock(messages_mutex);
    messages.push_back(std::move(message));
    if (messages.size() > kKept) messages.pop_front();
  }

  void keep(const PrimaryStream& parser) {
    const std::lock_guard lock(messages_mutex);
    if (parser.kinematics()) kinematics = parser.kinematics();
    if (parser.safety_checksum()) safety_checksum = parser.safety_checksum();
    states = parser.states();
  }

  void connect_if_lost() {
    if (stream && !stream->is_shut()) return;
    disconnect();
    connect();
  }

  void send(const std::string& script) {
    if (!stream || stream->is_shut())
      throw DeviceError("UR script port at " + to_text({address, port}), "the connection was lost",
                        "look whether the controller is up, then try again");
    const IoResult sent = stream->write_all(script, Deadline::in(options.send_timeout));
    if (sent) return;
    stream->shut();
    throw DeviceError("UR script port at " + to_text({address, port}),
                      concat("took ", sent.bytes, " of ", script.size(),
                             " bytes of a program: ", io_status_name(sent.status)),
                      "look whether the controller is up");
  }

  const std::string address;
  const PrimaryOptions options;
  std::mutex sending;  // guards the next three
  std::shared_ptr<TcpStream> stream;
  std::thread reader;
  int port = 0;
  std::mutex messages_mutex;
  std::deque<PrimaryMessage> messages;
  std::condition_variable noted;
  bool heard = false;  // a controller, on some connection
  std::string odd;     // what was wrong first on the present one
  std::optional<PrimaryKinematics> kinematics;
  std::optional<std::uint32_t> safety_checksum;
  long states = 0;  // of the present connection
};

PrimaryClient::PrimaryClient(const std::string& address, const PrimaryOptions& options)
    : link_(std::make_unique<Link>(address, options)) {}

PrimaryClient::~PrimaryClient() = default;

void PrimaryClient::send(const std::string& script) {
  require_whole(script);
  const std::lock_guard lock(link_->sending);
  link_->connect_if_lost();
  link_->send(script);
}

bool PrimaryClient::send_unless(const std::string& script, const std::atomic<bool>* stop) {
  require_whole(script);
  const std::lock_guard lock(link_->sending);
  if (stop != nullptr && *stop) return false;
  link_->send(script);
  return true;
}

void PrimaryClient::connect_if_lost() {
  const std::lock_guard lock(link_->sending);
  link_->connect_if_lost();
}

void PrimaryClient::reconnect() {
  const std::lock_guard lock(link_->sending);
  link_->disconnect();
  link_->connect();
}

std::vector<PrimaryMessage> PrimaryClient::take_messages() {
  const std::lock_guard lock(link_->messages_mutex);
  std::vector<PrimaryMessage> taken(link_->messages.begin(), link_->messages.end());
  link_->messages.clear();
  return taken;
}

void PrimaryClient::wait_until_heard(Deadline deadline) const {
  const double patience = deadline.left();
  std::unique_lock lock(link_->messages_mutex);
  while (!link_->heard && link_->odd.empty() && !deadline.over())
    link_->noted.wait_for(lock, std::chrono::duration<double>(deadline.or_interrupt().turn()));
  if (link_->heard) return;
  const std::string odd = link_->odd;
  lock.unlock();
  throw DeviceError("UR script port at " + to_text({link_->address, port()}),
                    odd.empty()
                        ? concat("says neither its version nor a state of the robot within ", patience, " s")
                        : "what listens there is no UR controller: " + odd,
                    "check the address and arm.primary_port (30001), and that no other program has the port");
}

std::optional<PrimaryKinematics> PrimaryClient::wait_for_kinematics(Deadline deadline) const {
  std::unique_lock lock(link_->messages_mutex);
  while (!link_->kinematics && link_->odd.empty() && !deadline.over())
    link_->noted.wait_for(lock, std::chrono::duration<double>(deadline.or_interrupt().turn()));
  return link_->kinematics;
}

std::optional<std::uint32_t> PrimaryClient::safety_checksum() const {
  const std::lock_guard lock(link_->messages_mutex);
  return link_->safety_checksum;
}

std::optional<std::uint32_t> PrimaryClient::wait_for_safety_checksum(Deadline deadline) const {
  std::unique_lock lock(link_->messages_mutex);
  while (!link_->safety_checksum && link_->states < kStatesWithout && link_->odd.empty() && !deadline.over())
    link_->noted.wait_for(lock, std::chrono::duration<double>(deadline.or_interrupt().turn()));
  return link_->safety_checksum;
}

std::string describe_other_safety(const std::optional<std::uint32_t>& found, const std::string& wanted) {
  if (wanted.empty()) return {};
  const auto expected = parse_checksum(wanted);
  require(expected.has_value(), "arm.safety_checksum has eight hexadecimal digits, not '", wanted, "'");
  if (!found)
    return concat(
        "the controller says no checksum of its safety configuration on its primary or secondary port, and "
        "the "
        "cell's arm.safety_checksum is ",
        wanted);
  if (*found == *expected) return {};
  return concat("the controller's safety configuration has the checksum ", checksum_text(*found),
                ", and the cell's arm.safety_checksum is ", wanted,
                ": it is not the configuration that the cell was set up with");
}

int PrimaryClient::port() const {
  const std::lock_guard lock(link_->sending);
  return link_->port;
}

}  // namespace stonestack::hardware
