#include "stonestack/hardware/ur/primary_client.hpp"

#include <array>
#include <deque>
#include <mutex>
#include <thread>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack {
namespace {

constexpr std::size_t kKept = 256, kChunk = 16384;
constexpr double kReadTurn = 1.0;     // s
constexpr int kRealtimePort = 30003;  // and its frames carry no type

}  // namespace

struct PrimaryClient::Link {
  Link(std::string at, const PrimaryOptions& o) : address(std::move(at)), options(o) {
    require(!options.ports.empty(), "a script port is needed");
    connect();
  }
  ~Link() { disconnect(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void connect() {
    std::string problems;
    for (const int candidate : options.ports) try {
        stream = std::make_shared<TcpStream>(
            TcpStream::connect({address, candidate}, Deadline::in(options.connect_timeout)));
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

  /// Until the connection ends; what it says is kept if it speaks of programs.
  void drain(TcpStream& from, bool speaks) {
    PrimaryStream parser;
    std::array<std::uint8_t, kChunk> bytes{};
    try {
      while (!from.is_shut()) {
        const IoResult read = from.read_some(bytes, Deadline::in(kReadTurn));
        if (read.status == IoStatus::kClosed) break;
        if (!speaks) continue;
        parser.feed({reinterpret_cast<const char*>(bytes.data()), read.bytes});
        while (auto message = parser.next()) keep(std::move(*message));
        if (parser.problem().empty()) continue;
        log_warning(from.name() + ": out of step: " + parser.problem() +
                    "; connecting anew at the next script");
        break;
      }
    } catch (const Error& error) {
      log_debug(error.what());
    }
    from.shut();
  }

  void keep(PrimaryMessage message) {
    const std::lock_guard lock(messages_mutex);
    messages.push_back(std::move(message));
    if (messages.size() > kKept) messages.pop_front();
  }

  void send(const std::string& script) {
    if (!stream || stream->is_shut()) {
      disconnect();
      connect();
    }
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
};

PrimaryClient::PrimaryClient(const std::string& address, const PrimaryOptions& options)
    : link_(std::make_unique<Link>(address, options)) {}

PrimaryClient::~PrimaryClient() = default;

void PrimaryClient::send(const std::string& script) {
  require(!script.empty() && script.back() == '\n', "a program ends with a new line");
  const std::lock_guard lock(link_->sending);
  link_->send(script);
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

int PrimaryClient::port() const {
  const std::lock_guard lock(link_->sending);
  return link_->port;
}

}  // namespace stonestack
