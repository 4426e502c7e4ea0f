#include "core/byte_stream.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/system_error.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

constexpr double kLongest = 1e9;                 // s, what a deadline may be away: 30 years
constexpr double kTurn = 0.1;                    // s between checks for Ctrl-C
constexpr std::size_t kMaxDropped = 16U << 20U;  // bytes: a peer that never stops sending must not hold us

// Errors of sockets and ttys whose peer is gone.
bool means_closed(int code) {
  return code == ECONNRESET || code == EPIPE || code == ENOTCONN || code == ECONNABORTED || code == EIO ||
         code == ETIMEDOUT;
}

}  // namespace

Deadline Deadline::in(double seconds) {
  require(std::isfinite(seconds) && seconds >= 0 && seconds <= kLongest,
          "a deadline lies 0 to 1e9 s away, not ", seconds, " s");
  return Deadline(host_seconds() + seconds);
}

double Deadline::left() const {
  return std::max(0.0, at_ - host_seconds());
}

Deadline Deadline::or_in(double seconds) const {
  return Deadline(std::min(at_, Deadline::in(seconds).at_), interruptible_);
}

Deadline Deadline::or_interrupt() const {
  return Deadline(at_, true);
}

double Deadline::turn() const {
  if (!interruptible_) return left();
  throw_if_interrupted();
  return std::min(left(), kTurn);
}

std::string_view io_status_name(IoStatus status) {
  switch (status) {
    case IoStatus::kDone:
      return "done";
    case IoStatus::kTimeOut:
      return "timed out";
    case IoStatus::kClosed:
      return "closed by the peer";
  }
  return "unknown";
}

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}
Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

ByteStream::ByteStream(Descriptor descriptor, std::string name)
    : descriptor_(std::move(descriptor)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      name_(std::move(name)) {
  struct stat info {};
  const int flags = ::fcntl(descriptor_.number(), F_GETFL);
  if (wake_.number() < 0 || flags < 0 || ::fcntl(descriptor_.number(), F_SETFL, flags | O_NONBLOCK) < 0 ||
      ::fstat(descriptor_.number(), &info) < 0)
    throw DeviceError(name_, "cannot be set up: " + system_text(errno), "look at `ulimit -n`");
  socket_ = S_ISSOCK(info.st_mode);
}

IoStatus ByteStream::wait(short events, Deadline deadline) const {
  for (;;) {
    std::array<pollfd, 2> watched{{{descriptor_.number(), events, 0}, {wake_.number(), POLLIN, 0}}};
    const double left = deadline.turn();
    const auto whole = static_cast<time_t>(left);
    const timespec limit{whole, static_cast<long>((left - static_cast<double>(whole)) * 1e9)};
    const int ready = ::ppoll(watched.data(), watched.size(), &limit, nullptr);
    if (ready < 0 && errno != EINTR)
      throw DeviceError(name_, "cannot be waited for: " + system_text(errno), "start the program again");
    if (ready > 0 && watched[1].revents != 0) return IoStatus::kClosed;
    if (ready > 0) return IoStatus::kDone;  // hang-ups and errors show in the call that follows
    if (deadline.over()) return IoStatus::kTimeOut;
  }
}

IoResult ByteStream::receive(std::span<std::uint8_t> bytes, Deadline deadline) {
  for (;;) {
    if (const IoStatus ready = wait(POLLIN, deadline); ready != IoStatus::kDone) return {ready, 0};
    const ssize_t count = ::read(descriptor_.number(), bytes.data(), bytes.size());
    if (count > 0) return {IoStatus::kDone, static_cast<std::size_t>(count)};
    if (count == 0 || means_closed(errno)) return {IoStatus::kClosed, 0};
    if (errno != EAGAIN && errno != EINTR)
      throw DeviceError(name_, "cannot be read: " + system_text(errno), "open the link again");
  }
}

std::size_t ByteStream::take_kept(std::span<std::uint8_t> bytes) {
  const std::size_t count = std::min(bytes.size(), kept_.size());
  std::copy_n(kept_.begin(), count, bytes.begin());
  kept_.erase(0, count);
  return count;
}

IoResult ByteStream::read_some(std::span<std::uint8_t> bytes, Deadline deadline) {
  if (const std::size_t count = take_kept(bytes); count > 0 || bytes.empty()) return {IoStatus::kDone, count};
  return receive(bytes, deadline);
}

IoResult ByteStream::read_exact(std::span<std::uint8_t> bytes, Deadline deadline) {
  std::size_t done = take_kept(bytes);
  while (done < bytes.size()) {
    const IoResult part = receive(bytes.subspan(done), deadline);
    done += part.bytes;
    if (!part) return {part.status, done};
    if (done < bytes.size() && deadline.over()) return {IoStatus::kTimeOut, done};
  }
  return {IoStatus::kDone, done};
}

LineResult ByteStream::read_line(std::size_t longest, Deadline deadline) {
  for (std::size_t searched = 0;;) {
    const auto end = kept_.find('\n', searched);
    if (std::min(end, kept_.size()) > longest)
      throw DeviceError(name_, concat("sent a line longer than ", longest, " bytes"),
                        "check that the right program listens there");
    if (end != std::string::npos) {
      std::string line = kept_.substr(0, end);
      kept_.erase(0, end + 1);
      if (!line.empty() && line.back() == '\r') line.pop_back();
      return {IoStatus::kDone, std::move(line)};
    }
    searched = kept_.size();
    std::array<std::uint8_t, 512> part;
    const IoResult got = receive(part, deadline);
    if (!got) return {got.status, {}};
    kept_.append(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(got.bytes));
    if (deadline.over() && kept_.find('\n', searched) == std::string::npos) return {IoStatus::kTimeOut, {}};
  }
}

IoResult ByteStream::write_all(std::span<const std::uint8_t> bytes, Deadline deadline) {
  for (std::size_t done = 0;;) {
    if (done == bytes.size()) return {IoStatus::kDone, done};
    if (const IoStatus ready = wait(POLLOUT, deadline); ready != IoStatus::kDone) return {ready, done};
    const auto rest = bytes.subspan(done);
    const ssize_t count = socket_ ? ::send(descriptor_.number(), rest.data(), rest.size(), MSG_NOSIGNAL)
                                  : ::write(descriptor_.number(), rest.data(), rest.size());
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
      if (done < bytes.size() && deadline.over()) return {IoStatus::kTimeOut, done};
    } else if (means_closed(errno)) {
      return {IoStatus::kClosed, done};
    } else if (errno != EAGAIN && errno != EINTR) {
      throw DeviceError(name_, "cannot be written: " + system_text(errno), "open the link again");
    }
  }
}

IoResult ByteStream::write_all(std::string_view text, Deadline deadline) {
  return write_all({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, deadline);
}

std::size_t ByteStream::discard_input() {
  std::size_t dropped = kept_.size();
  kept_.clear();
  std::array<std::uint8_t, 4096> bytes;
  while (dropped < kMaxDropped) {
    const IoResult part = receive(bytes, Deadline::in(0));
    if (!part) break;
    dropped += part.bytes;
  }
  return dropped;
}

void ByteStream::shut() noexcept {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_.number(), &one, sizeof one);
  if (socket_) ::shutdown(descriptor_.number(), SHUT_RDWR);
}

bool ByteStream::is_shut() const {
  pollfd watched{wake_.number(), POLLIN, 0};
  return ::poll(&watched, 1, 0) > 0;
}

}  // namespace stonestack::core
