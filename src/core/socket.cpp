#include "core/socket.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "core/system_error.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

// Keep-alive: first probe after 15 s of silence, then every 5 s, dead after 3 without an answer.
constexpr int kIdle = 15, kInterval = 5, kProbes = 3;
constexpr const char* kLocalHost = "localhost";
constexpr std::size_t kLongestName = 253;  // RFC 1035

sockaddr_in parse(const Endpoint& endpoint) {
  sockaddr_in address{};
  const std::string& text = endpoint.address == kLocalHost ? "127.0.0.1" : endpoint.address;
  require(::inet_pton(AF_INET, text.c_str(), &address.sin_addr) == 1, "'", endpoint.address,
          "' is not an address; give numbers such as 192.168.1.11, or for a device its name in the network");
  require(endpoint.port >= 0 && endpoint.port <= 65535, "a port lies in 0..65535, not ", endpoint.port);
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(endpoint.port));
  return address;
}

Descriptor new_socket(const std::string& name) {
  Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (socket.number() < 0) throw DeviceError(name, "no socket: " + system_text(errno), "look at `ulimit -n`");
  return socket;
}

void set_option(const Descriptor& socket, int level, int option, int value) {
  ::setsockopt(socket.number(), level, option, &value, sizeof value);
}

void make_prompt(const Descriptor& socket) {
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, kIdle);
  set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, kInterval);
  set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, kProbes);
}

// Waits for `first` (and `second` if not negative); a mask of the ready ones, 0 at the deadline.
unsigned wait_for(pollfd first, int second, Deadline deadline) {
  std::array<pollfd, 2> watched{{first, {second, POLLIN, 0}}};
  for (;;) {
    const double left = deadline.turn();
    const auto whole = static_cast<time_t>(left);
    const timespec limit{whole, static_cast<long>((left - static_cast<double>(whole)) * 1e9)};
    const int ready = ::ppoll(watched.data(), second < 0 ? 1 : 2, &limit, nullptr);
    if (ready > 0) return (watched[0].revents != 0 ? 1U : 0U) | (watched[1].revents != 0 ? 2U : 0U);
    if (deadline.over()) return 0;
  }
}

/// Letters, digits and hyphens between dots (RFC 1123), and underscores, which some networks have. One whose
/// last part is a number is an address with a mistake in it.
bool is_host_name(const std::string& text) {
  constexpr std::string_view kDigits = "0123456789";
  constexpr std::string_view kOthers = "-_.ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
  const bool known = std::all_of(text.begin(), text.end(), [&](char c) {
    return kDigits.find(c) != kDigits.npos || kOthers.find(c) != kOthers.npos;
  });
  const std::string last = text.substr(text.rfind('.') + 1);  // npos + 1 is the whole
  return known && text.size() <= kLongestName && text.find("..") == text.npos && text.front() != '.' &&
         !last.empty() && last.find_first_not_of(kDigits) != last.npos;
}

struct LookUp {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  int problem = 0;  // of getaddrinfo
  in_addr address{};
};

/// getaddrinfo has no deadline, so it runs in a thread of its own, which is left behind when it takes longer
/// (the system's resolver ends it after some seconds).
in_addr look_up(const Endpoint& endpoint, Deadline deadline) {
  const auto found = std::make_shared<LookUp>();
  std::thread([found, name = endpoint.address] {
    addrinfo wanted{}, *list = nullptr;
    wanted.ai_family = AF_INET;
    wanted.ai_socktype = SOCK_STREAM;
    const int problem = ::getaddrinfo(name.c_str(), nullptr, &wanted, &list);
    const std::lock_guard lock(found->mutex);
    if (problem == 0) found->address = reinterpret_cast<const sockaddr_in*>(list->ai_addr)->sin_addr;
    if (list != nullptr) ::freeaddrinfo(list);
    found->problem = problem;
    found->done = true;
    found->changed.notify_all();
  }).detach();
  constexpr const char* kRemedy = "check its spelling and the name server, or give the address in numbers";
  std::unique_lock lock(found->mutex);
  do {
    if (deadline.over())
      throw DeviceError(to_text(endpoint),
                        concat("the name '", endpoint.address, "' was not looked up before the deadline"),
                        kRemedy);
  } while (!found->changed.wait_for(lock, std::chrono::duration<double>(deadline.turn()),
                                    [&] { return found->done; }));
  if (found->problem != 0)
    throw DeviceError(
        to_text(endpoint),
        concat("the name '", endpoint.address, "' has no IPv4 address: ", ::gai_strerror(found->problem)),
        kRemedy);
  return found->address;
}

sockaddr_in resolve(const Endpoint& endpoint, Deadline deadline) {
  if (!is_host_name(endpoint.address) || endpoint.address == kLocalHost) return parse(endpoint);
  sockaddr_in address = parse({kLocalHost, endpoint.port});
  address.sin_addr = look_up(endpoint, deadline);
  return address;
}

[[noreturn]] void throw_unreachable(const std::string& name, int code) {
  if (code == ECONNREFUSED)
    throw DeviceError(name, "connection refused",
                      "switch the device on, check the port, and that its network service is enabled");
  throw DeviceError(name, "cannot be reached: " + system_text(code), "check the address and the cable");
}

}  // namespace

std::string to_text(const Endpoint& endpoint) {
  return concat(endpoint.address, ":", endpoint.port);
}

bool is_loopback(const std::string& address) {
  return (ntohl(parse({address, 0}).sin_addr.s_addr) >> 24U) == 127U;
}

TcpStream TcpStream::connect(const Endpoint& peer, Deadline deadline) {
  const std::string name = to_text(peer);
  require(peer.port > 0, "a port to connect to lies in 1..65535, not ", peer.port);
  const sockaddr_in address = resolve(peer, deadline);
  Descriptor socket = new_socket(name);
  if (::connect(socket.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0) {
    if (errno != EINPROGRESS && errno != EINTR) throw_unreachable(name, errno);
    if (wait_for({socket.number(), POLLOUT, 0}, -1, deadline) == 0)
      throw DeviceError(name, "did not answer before the deadline", "check the address and the cable");
    int code = 0;
    socklen_t size = sizeof code;
    ::getsockopt(socket.number(), SOL_SOCKET, SO_ERROR, &code, &size);
    if (code != 0) throw_unreachable(name, code);
  }
  make_prompt(socket);
  return {std::move(socket), name};
}

TcpListener::TcpListener(const ListenOptions& options)
    : wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), endpoint_{options.address, options.port} {
  const std::string name = to_text(endpoint_);
  sockaddr_in address = parse(endpoint_);
  require(options.allow_remote || is_loopback(options.address), "will not listen on ", name,
          ": only loopback (127.x.y.z) unless other machines are allowed explicitly");
  socket_ = new_socket(name);
  set_option(socket_, SOL_SOCKET, SO_REUSEADDR, 1);
  if (wake_.number() < 0 ||
      ::bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0 ||
      ::listen(socket_.number(), options.waiting) < 0) {
    const int code = errno;
    throw DeviceError(name, "cannot listen: " + system_text(code),
                      code == EACCES       ? "ports below 1024 need root or CAP_NET_BIND_SERVICE"
                      : code == EADDRINUSE ? "another program has the port; stop it or give another one"
                                           : "give an address of this machine");
  }
  socklen_t size = sizeof address;
  ::getsockname(socket_.number(), reinterpret_cast<sockaddr*>(&address), &size);
  endpoint_.port = ntohs(address.sin_port);
}

std::optional<TcpStream> TcpListener::accept(Deadline deadline) {
  for (;;) {
    const unsigned ready = wait_for({socket_.number(), POLLIN, 0}, wake_.number(), deadline);
    if (ready == 0 || (ready & 2U) != 0) return std::nullopt;
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    Descriptor socket(
        ::accept4(socket_.number(), reinterpret_cast<sockaddr*>(&peer), &size, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket.number() >= 0) {
      make_prompt(socket);
      std::array<char, INET_ADDRSTRLEN> text{};
      ::inet_ntop(AF_INET, &peer.sin_addr, text.data(), text.size());
      return TcpStream(std::move(socket), concat(text.data(), ":", ntohs(peer.sin_port)));
    }
    if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED)
      throw DeviceError(to_text(endpoint_), "cannot accept: " + system_text(errno), "look at `ulimit -n`");
  }
}

void TcpListener::close() noexcept {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_.number(), &one, sizeof one);
}

bool TcpListener::is_closed() const {
  pollfd watched{wake_.number(), POLLIN, 0};
  return ::poll(&watched, 1, 0) > 0;
}

}  // namespace stonestack::core
