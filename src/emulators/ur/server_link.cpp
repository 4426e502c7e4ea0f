#include "emulators/ur/server_link.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kMaxBehind = 10.0;           // s without progress until a client is disconnected
constexpr int kSendBuffer = 32768;            // bytes in the kernel: a slow reader is noticed soon
constexpr std::size_t kMaxPending = 1 << 20;  // bytes
constexpr std::size_t kMaxLinks = 32;

}  // namespace

ServerLink::ServerLink(TcpStream stream, UrController& controller, Unread unread, int reads_a_step)
    : stream_(std::move(stream)), controller_(&controller), unread_(unread), reads_a_step_(reads_a_step) {
  ::setsockopt(stream_.descriptor(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof(kSendBuffer));
}

void ServerLink::pump() {
  if (dead_) return;
  std::array<std::uint8_t, 8192> buffer;
  for (int k = 0; k < reads_a_step_ && !dead_ && !has_enough(); ++k) {
    const IoResult result = stream_.read_some(buffer, Deadline::in(0));
    if (result.bytes > 0 && !mute_) receive({reinterpret_cast<const char*>(buffer.data()), result.bytes});
    if (result.status == IoStatus::kClosed) dead_ = true;
    if (result.status != IoStatus::kDone) break;
  }
  flush();
}

void ServerLink::flush() {
  if (dead_ || mute_ || pending_.empty()) return;
  const std::size_t piece = controller_->faults.split_packets ? 1 : pending_.size();
  std::size_t sent = 0;
  while (sent < pending_.size()) {
    const std::string_view next = std::string_view(pending_).substr(sent, piece);
    const IoResult result = stream_.write_all(next, Deadline::in(0));
    sent += result.bytes;
    if (result.status == IoStatus::kClosed) dead_ = true;
    if (result.status != IoStatus::kDone) break;
  }
  pending_.erase(0, sent);
  if (pending_.empty() || unread_ == Unread::kSkipped) {
    behind_since_ = -1.0;
  } else if (behind_since_ < 0 || sent > 0) {
    behind_since_ = controller_->uptime();
  } else if (controller_->uptime() - behind_since_ > kMaxBehind) {
    dead_ = true;
  }
}

void ServerLink::send(std::string_view bytes) {
  if (dead_ || mute_) return;
  if (pending_.size() + bytes.size() > kMaxPending) {
    ++skipped_;
    dead_ = unread_ == Unread::kDisconnected;
    return;
  }
  pending_ += bytes;
  flush();
}

void ServerLink::offer(std::string_view bytes) {
  flush();
  if (pending_.empty())
    send(bytes);
  else
    ++skipped_;
}

ServerPort::ServerPort(const ListenOptions& options, MakeLink make)
    : options_(options), make_(std::move(make)) {
  reopen();
  options_.port = listener_->endpoint().port;
}

void ServerPort::reopen() {
  if (!listener_) listener_ = std::make_unique<TcpListener>(options_);
}

void ServerPort::shut() {
  listener_.reset();
  links_.clear();
}

void ServerPort::accept() {
  while (listener_) {
    try {
      auto stream = listener_->accept(Deadline::in(0));
      if (!stream) return;
      if (links_.size() < kMaxLinks) links_.push_back(make_(std::move(*stream)));
    } catch (const DeviceError& problem) {  // out of sockets: those who are there go on
      if (!cannot_accept_) log_warning(concat("simulated UR controller: ", problem.what()));
      cannot_accept_ = true;
      return;
    }
    cannot_accept_ = false;
  }
}

void ServerPort::pump() {
  for (auto& link : links_) link->pump();
  links_.erase(std::remove_if(links_.begin(), links_.end(), [](const auto& link) { return link->dead(); }),
               links_.end());
}

void ServerPort::after_step() {
  for (auto& link : links_) link->after_step();
}

void ServerPort::mute_links() {
  for (auto& link : links_) link->mute();
}

}  // namespace stonestack::emulators
