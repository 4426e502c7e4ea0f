#pragma once
#include <string>

#include "stonestack/core/byte_stream.hpp"

namespace stonestack::core {

/// A serial line: raw, 8 data bits, no parity, 1 stop bit, no flow control. Locked against other programs
/// that lock (flock) as long as it is open.
class SerialPort : public ByteStream {
 public:
  using ByteStream::ByteStream;
  /// Opens a tty ("/dev/ttyUSB0", a pseudo terminal). Throws DeviceError when it is missing, not a tty, not
  /// permitted or owned by somebody else, InvalidArgument for a rate that termios does not know.
  [[nodiscard]] static SerialPort open(const std::string& path, int baud);
};

/// Both ends of a serial line for a simulated device: this object reads and writes one end, other programs
/// open `path`. Raw from the start, so that nothing is echoed; stays up while clients come and go.
class PseudoTerminal : public ByteStream {
 public:
  /// Makes one. A `link` that is not empty becomes a symbolic link to it for as long as the object lives; a
  /// dead link of that name is replaced. Throws DeviceError.
  [[nodiscard]] static PseudoTerminal open(const std::string& link = "");
  ~PseudoTerminal();
  PseudoTerminal(PseudoTerminal&& other) noexcept = default;
  PseudoTerminal& operator=(PseudoTerminal&&) = delete;
  /// "/dev/pts/N".
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Drops what was written and not yet read by a client (a serial line keeps nothing for a late reader).
  void discard_output();

 private:
  PseudoTerminal(Descriptor master, Descriptor client_end, std::string path, std::string link);
  Descriptor client_end_;  // held open, so that a client that leaves is not a hang-up
  std::string path_;
  std::string link_;
};

}  // namespace stonestack::core
