// Connections that a program opens itself; UR's own client library lets the robot call back by these. The
// simulated robot calls loopback addresses only.
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>

#include "emulators/ur/builtins.hpp"
#include "protocol/big_endian.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kConnectSeconds = 0.2;
constexpr std::size_t kMaxSockets = 16;
constexpr std::size_t kMaxReceived = 1 << 20;
constexpr long long kMaxNumbers = 30;  // a read asks for, as on the controller
constexpr double kDefaultTimeout = 2.0;

/// A connection that is being made. Nobody is waited for: whoever does not answer would hold up the control
/// steps, and with them every other client.
class CallOut {
 public:
  enum class State { kInProgress, kThere, kRefused };
  CallOut(const std::string& address, int port)
      : name_(concat(address, ':', port)),
        socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_in peer{};
    peer.sin_family = AF_INET;
    peer.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, address == "localhost" ? "127.0.0.1" : address.c_str(), &peer.sin_addr);
    const int one = 1;
    ::setsockopt(socket_.number(), IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    refused_ = ::connect(socket_.number(), reinterpret_cast<const sockaddr*>(&peer), sizeof peer) < 0 &&
               errno != EINPROGRESS;
  }
  [[nodiscard]] State poll_once() const {
    if (refused_) return State::kRefused;
    pollfd watched{socket_.number(), POLLOUT, 0};
    if (::poll(&watched, 1, 0) <= 0) return State::kInProgress;
    int code = 0;
    socklen_t size = sizeof code;
    ::getsockopt(socket_.number(), SOL_SOCKET, SO_ERROR, &code, &size);
    return code == 0 ? State::kThere : State::kRefused;
  }
  [[nodiscard]] TcpStream take() { return {std::move(socket_), name_}; }

 private:
  std::string name_;
  Descriptor socket_;
  bool refused_ = false;
};

std::string name_of(const BuiltinCall& call, std::size_t i) {
  return call.has(i) ? text(arg(call, i)) : "socket_0";
}

ScriptSocket* find(UrController& host, const std::string& name) {
  const auto it = host.sockets.find(name);
  return it == host.sockets.end() ? nullptr : &it->second;
}

Outcome open(BuiltinCall& call) {
  const std::string address = text(arg(call, 0)), name = name_of(call, 2);
  const long long port = integer(arg(call, 1));
  controller(call).sockets.erase(name);
  if (port < 1 || port > 65535 || controller(call).sockets.size() >= kMaxSockets) return Value(false);
  try {
    if (!is_loopback(address)) return Value(false);
  } catch (const Error&) {
    return Value(false);
  }
  const auto call_out = std::make_shared<CallOut>(address, static_cast<int>(port));
  auto poll_once = [&host = controller(call), name, call_out,
                    until = controller(call).uptime() + kConnectSeconds]() -> std::optional<Value> {
    const auto state = call_out->poll_once();
    if (state == CallOut::State::kInProgress && host.uptime() < until) return std::nullopt;
    if (state != CallOut::State::kThere) return Value(false);
    host.sockets.erase(name);
    host.sockets.emplace(name, ScriptSocket{call_out->take(), "", false});
    return Value(true);
  };
  if (auto at_once = poll_once()) return *at_once;
  return Wait(poll_once);
}

Outcome close(BuiltinCall& call) {
  controller(call).sockets.erase(name_of(call, 0));
  return Value();
}

// Waits until `take` finds what it wants in what was received; `leave` gives the value when time is up or the
// link ends. A time of 0 waits for ever.
Outcome wait_for(BuiltinCall& call, const std::string& name, double seconds,
                 std::function<Value(std::string& received)> leave,
                 std::function<std::optional<Value>(std::string& received)> take) {
  const double until = seconds > 0 ? controller(call).uptime() + seconds : INFINITY;
  auto poll_once = [&host = controller(call), name, until, leave, take]() mutable -> std::optional<Value> {
    ScriptSocket* socket = find(host, name);
    std::string none;
    if (!socket) return leave(none);
    receive(*socket);
    if (auto value = take(socket->received)) return value;
    if (socket->closed || host.uptime() >= until) return leave(socket->received);
    return std::nullopt;
  };
  if (auto at_once = poll_once()) return *at_once;
  return Wait(poll_once);
}

Outcome wait_for(BuiltinCall& call, const std::string& name, double seconds, const Value& nothing,
                 std::function<std::optional<Value>(std::string& received)> take) {
  return wait_for(
      call, name, seconds, [nothing](std::string&) { return nothing; }, std::move(take));
}

bool send_to(ScriptSocket& socket, const std::string& bytes) {
  if (socket.closed) return false;
  const IoResult result = socket.stream.write_all(bytes, Deadline::in(0));
  if (result.status != IoStatus::kDone) socket.closed = true;
  return static_cast<bool>(result);
}

Outcome send(BuiltinCall& call, const std::string& bytes, std::size_t name = 1) {
  ScriptSocket* socket = find(controller(call), name_of(call, name));
  return Value(socket != nullptr && send_to(*socket, bytes));
}

Outcome set_variable(BuiltinCall& call) {
  static_cast<void>(send(call, concat("SET ", text(arg(call, 0)), " ", integer(arg(call, 1)), "\n"), 2));
  return Value();
}

Outcome read_integers(BuiltinCall& call) {
  const long long count = integer(arg(call, 0));
  if (count < 1 || count > kMaxNumbers) throw ScriptError{"Value error: 1 to 30 numbers can be read"};
  List nothing{Value(-1)};
  for (long long i = 0; i < count; ++i) nothing.emplace_back(0);
  return wait_for(call, name_of(call, 1), call.number_or(2, kDefaultTimeout), nothing,
                  [count](std::string& received) -> std::optional<Value> {
                    const auto bytes = static_cast<std::size_t>(4 * count);
                    if (received.size() < bytes) return std::nullopt;
                    List list{Value(count)};
                    BigEndianReader reader(received);
                    for (long long i = 0; i < count; ++i)
                      list.emplace_back(static_cast<long long>(reader.get<std::int32_t>()));
                    received.erase(0, bytes);
                    return Value(std::move(list));
                  });
}

// "(1.5, 2)": the count, then the numbers.
Outcome read_floats(BuiltinCall& call) {
  const long long count = integer(arg(call, 0));
  if (count < 1 || count > kMaxNumbers) throw ScriptError{"Value error: 1 to 30 numbers can be read"};
  List nothing{Value(0)};
  for (long long i = 0; i < count; ++i) nothing.emplace_back(std::nan(""));
  return wait_for(call, name_of(call, 1), call.number_or(2, kDefaultTimeout), nothing,
                  [count](std::string& received) -> std::optional<Value> {
                    const auto begin = received.find('('), end = received.find(')');
                    if (end == std::string::npos) return std::nullopt;
                    List list{Value(0)};
                    const char* at = received.c_str() + (begin == std::string::npos ? 0 : begin + 1);
                    for (char* next = nullptr; list.size() <= static_cast<std::size_t>(count);
                         at = next + 1) {
                      list.emplace_back(std::strtod(at, &next));
                      if (next == at || *next != ',') break;
                    }
                    list[0] = static_cast<long long>(list.size() - 1);
                    received.erase(0, end + 1);
                    return Value(std::move(list));
                  });
}

// "name 120": the number, also behind what somebody has not read. A line end need not come: what stayed as it
// was for a control step is all.
Outcome get_variable(BuiltinCall& call) {
  const std::string name = text(arg(call, 0)) + " ";
  ScriptSocket* socket = find(controller(call), name_of(call, 1));
  if (!socket || !send_to(*socket, "GET " + text(arg(call, 0)) + "\n")) return Value(0);
  std::size_t seen = 0;
  return wait_for(call, name_of(call, 1), kDefaultTimeout, Value(0),
                  [name, seen](std::string& received) mutable -> std::optional<Value> {
                    const auto begin = received.find(name);
                    if (begin == std::string::npos) return std::nullopt;
                    const auto end = received.find('\n', begin);
                    const bool all = end != std::string::npos || seen == received.size();
                    seen = received.size();
                    char* behind = nullptr;
                    const char* number = received.c_str() + begin + name.size();
                    const long long value = std::strtoll(number, &behind, 10);
                    if (!all || behind == number) return std::nullopt;
                    received.erase(0, end == std::string::npos ? end : end + 1);
                    return Value(value);
                  });
}

// As many bytes as came in time: Robotiq's scripts ask for more than there may be.
Outcome read_bytes(BuiltinCall& call) {
  const long long count = integer(arg(call, 0));
  if (count < 1 || count > kMaxNumbers) throw ScriptError{"Value error: 1 to 30 bytes can be read"};
  const auto list_of = [count](std::string& received) {
    const auto size = std::min(static_cast<std::size_t>(count), received.size());
    List list{Value(static_cast<long long>(size))};
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      list.emplace_back(i < size ? static_cast<unsigned char>(received[i]) : -1);
    received.erase(0, size);
    return Value(std::move(list));
  };
  return wait_for(call, name_of(call, 1), call.number_or(2, kDefaultTimeout), list_of,
                  [count, list_of](std::string& received) -> std::optional<Value> {
                    if (received.size() < static_cast<std::size_t>(count)) return std::nullopt;
                    return list_of(received);
                  });
}

Outcome read_line(BuiltinCall& call) {
  return wait_for(call, name_of(call, 0), call.number_or(1, kDefaultTimeout), Value(""),
                  [](std::string& received) -> std::optional<Value> {
                    const auto end = received.find('\n');
                    if (end == std::string::npos || end > kLongestText) return std::nullopt;
                    std::string line = received.substr(0, end);
                    received.erase(0, end + 1);
                    return Value(std::move(line));
                  });
}

Outcome read_any(BuiltinCall& call) {
  return wait_for(call, name_of(call, 0), call.number_or(4, kDefaultTimeout), Value(""),
                  [](std::string& received) -> std::optional<Value> {
                    if (received.empty()) return std::nullopt;
                    std::string all = received.substr(0, kLongestText);
                    received.erase(0, all.size());
                    return Value(std::move(all));
                  });
}

}  // namespace

void receive(ScriptSocket& socket) {
  std::array<std::uint8_t, 4096> buffer;
  while (!socket.closed && socket.received.size() < kMaxReceived) {
    const IoResult result = socket.stream.read_some(buffer, Deadline::in(0));
    socket.received.append(reinterpret_cast<const char*>(buffer.data()), result.bytes);
    if (result.status == IoStatus::kClosed) socket.closed = true;
    if (result.status != IoStatus::kDone) return;
  }
}

void add_sockets(std::vector<Builtin>& list) {
  list.push_back({"socket_open", {"address", "port", "socket_name"}, 2, open});
  list.push_back({"socket_close", {"socket_name"}, 0, close});
  list.push_back({"socket_read_binary_integer", {"number", "socket_name", "timeout"}, 1, read_integers});
  list.push_back({"socket_read_ascii_float", {"number", "socket_name", "timeout"}, 1, read_floats});
  list.push_back({"socket_read_byte_list", {"number", "socket_name", "timeout"}, 1, read_bytes});
  list.push_back({"socket_set_var", {"name", "value", "socket_name"}, 2, set_variable});
  list.push_back({"socket_get_var", {"name", "socket_name"}, 1, get_variable});
  list.push_back({"socket_read_line", {"socket_name", "timeout"}, 0, read_line});
  list.push_back({"socket_read_string",
                  {"socket_name", "prefix", "suffix", "interpret_escape", "timeout"},
                  0,
                  read_any});
  list.push_back({"socket_send_int", {"value", "socket_name"}, 1, [](BuiltinCall& c) {
                    std::string bytes;
                    put(bytes, static_cast<std::int32_t>(integer(arg(c, 0))));
                    return send(c, bytes);
                  }});
  list.push_back({"socket_send_byte", {"value", "socket_name"}, 1, [](BuiltinCall& c) {
                    return send(c, std::string(1, static_cast<char>(integer(arg(c, 0)))));
                  }});
  list.push_back({"socket_send_string", {"str", "socket_name"}, 1, [](BuiltinCall& c) {
                    return send(c, print(arg(c, 0)));
                  }});
  list.push_back({"socket_send_line", {"str", "socket_name"}, 1, [](BuiltinCall& c) {
                    return send(c, print(arg(c, 0)) + "\n");
                  }});
}

}  // namespace stonestack::emulators
