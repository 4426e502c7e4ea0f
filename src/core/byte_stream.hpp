#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

namespace stonestack::core {

/// A point of the host's steady time that a call must not outlast. Pass one deadline through all steps of a
/// transaction, so that the whole of it is bounded.
class Deadline {
 public:
  /// `seconds` from now; 0 means "do not wait".
  /// @throws InvalidArgument for what is negative or not finite.
  [[nodiscard]] static Deadline in(double seconds);
  /// Seconds left, 0 when over.
  [[nodiscard]] double left() const;
  [[nodiscard]] bool over() const { return left() <= 0.0; }
  /// The earlier of the two.
  [[nodiscard]] Deadline or_in(double seconds) const;
  /// Deadline at the same point; a wait for it throws Interrupted within 0.1 s of Ctrl-C. Not for what must
  /// still work then, as stopping an arm.
  [[nodiscard]] Deadline or_interrupt() const;
  /// Seconds to wait before the next check of it. Throws Interrupted, see `or_interrupt`.
  [[nodiscard]] double turn() const;

 private:
  explicit Deadline(double at, bool interruptible = false) : at_(at), interruptible_(interruptible) {}
  double at_;  // s of the steady clock
  bool interruptible_ = false;
};

/// How a read or a write ended. Anything else (a broken descriptor, no memory) is a DeviceError.
enum class IoStatus {
  kDone,
  kTimeOut,  ///< the deadline came first; what was already read or written is counted in the result
  kClosed,   ///< the peer closed or reset the link, the tty hung up, or `shut` was called
};
[[nodiscard]] std::string_view io_status_name(IoStatus status);

struct [[nodiscard]] IoResult {
  IoStatus status = IoStatus::kDone;
  std::size_t bytes = 0;  ///< moved by this call, whatever the status
  [[nodiscard]] explicit operator bool() const { return status == IoStatus::kDone; }
};

struct [[nodiscard]] LineResult {
  IoStatus status = IoStatus::kDone;
  std::string line;  ///< without "\n" or "\r\n"; empty unless kDone
  [[nodiscard]] explicit operator bool() const { return status == IoStatus::kDone; }
};

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// Bytes to and from a socket or a tty; every call has a deadline. One thread may read while another writes;
/// `shut` may be called from any thread. Never raises SIGPIPE.
class ByteStream {
 public:
  /// Takes over an open descriptor and makes it non-blocking. `name` stands in every error.
  ByteStream(Descriptor descriptor, std::string name);

  /// Whatever is there, at least one byte. `bytes` may stay partly unused; an empty span is kDone at once.
  IoResult read_some(std::span<std::uint8_t> bytes, Deadline deadline);
  /// Fills `bytes`; bytes that trickle in do not put off the deadline. After kTimeOut the bytes counted in
  /// the result are lost to later reads.
  IoResult read_exact(std::span<std::uint8_t> bytes, Deadline deadline);
  /// One line up to '\n'. After kTimeOut the part that came is kept for the next call.
  /// @throws DeviceError for a line longer than `longest`.
  LineResult read_line(std::size_t longest, Deadline deadline);
  IoResult write_all(std::span<const std::uint8_t> bytes, Deadline deadline);
  IoResult write_all(std::string_view text, Deadline deadline);
  /// Drops what has arrived so far; the number of bytes.
  std::size_t discard_input();

  /// Ends the link: every waiting and later call reports kClosed. Thread-safe.
  void shut() noexcept;
  [[nodiscard]] bool is_shut() const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] int descriptor() const { return descriptor_.number(); }

 private:
  [[nodiscard]] IoStatus wait(short events, Deadline deadline) const;
  [[nodiscard]] IoResult receive(std::span<std::uint8_t> bytes, Deadline deadline);
  std::size_t take_kept(std::span<std::uint8_t> bytes);

  Descriptor descriptor_;
  Descriptor wake_;
  bool socket_ = false;
  std::string name_;
  std::string kept_;  // read ahead by read_line
};

}  // namespace stonestack::core
