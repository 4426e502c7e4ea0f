#include "core/serial.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "core/system_error.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

namespace fs = std::filesystem;

speed_t find_speed(int baud) {
  constexpr std::array<std::pair<int, speed_t>, 8> kSpeeds{{{9600, B9600},
                                                            {19200, B19200},
                                                            {38400, B38400},
                                                            {57600, B57600},
                                                            {115200, B115200},
                                                            {230400, B230400},
                                                            {460800, B460800},
                                                            {921600, B921600}}};
  for (const auto& [rate, speed] : kSpeeds)
    if (rate == baud) return speed;
  throw InvalidArgument(
      concat("a serial line runs at 9600, 19200, 38400, 57600, 115200, 230400, 460800 or "
             "921600 baud, not ",
             baud));
}

void make_raw(int descriptor, speed_t speed, const std::string& name) {
  termios settings{};
  if (::tcgetattr(descriptor, &settings) < 0)
    throw DeviceError(name, "is not a serial line: " + system_text(errno), "give a tty such as /dev/ttyUSB0");
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | CRTSCTS);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  ::cfsetspeed(&settings, speed);
  if (::tcsetattr(descriptor, TCSANOW, &settings) < 0)
    throw DeviceError(name, "cannot be set up: " + system_text(errno), "check that the line has this rate");
}

std::string remedy_for_open(int code) {
  if (code == EACCES) return "join the group dialout, or change the rights of the file";
  if (code == EBUSY) return "end the other program that uses it";
  return "plug the device in and look at `ls /dev/serial/by-id`";
}

}  // namespace

SerialPort SerialPort::open(const std::string& path, int baud) {
  const speed_t speed = find_speed(baud);
  Descriptor line(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (line.number() < 0)
    throw DeviceError(path, "cannot be opened: " + system_text(errno), remedy_for_open(errno));
  make_raw(line.number(), speed, path);
  if (::flock(line.number(), LOCK_EX | LOCK_NB) < 0)
    throw DeviceError(path, "is in use: " + system_text(errno), remedy_for_open(EBUSY));
  return {std::move(line), path};
}

PseudoTerminal PseudoTerminal::open(const std::string& link) {
  Descriptor master(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  std::array<char, 64> path{};
  if (master.number() < 0 || ::grantpt(master.number()) < 0 || ::unlockpt(master.number()) < 0 ||
      ::ptsname_r(master.number(), path.data(), path.size()) != 0)
    throw DeviceError("pseudo terminal", "cannot be made: " + system_text(errno), "mount /dev/pts");
  Descriptor client_end(::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (client_end.number() < 0)
    throw DeviceError(path.data(), "cannot be opened: " + system_text(errno), "mount /dev/pts");
  make_raw(client_end.number(), B115200, path.data());
  if (!link.empty()) {
    std::error_code problem;
    if (fs::is_symlink(link, problem) && !fs::exists(link, problem)) fs::remove(link, problem);
    fs::create_symlink(path.data(), link, problem);
    if (problem)
      throw DeviceError(link, "cannot link to " + std::string(path.data()) + ": " + problem.message(),
                        "give a name that is free");
  }
  return {std::move(master), std::move(client_end), path.data(), link};
}

PseudoTerminal::PseudoTerminal(Descriptor master, Descriptor client_end, std::string path, std::string link)
    : ByteStream(std::move(master), path),
      client_end_(std::move(client_end)),
      path_(std::move(path)),
      link_(std::move(link)) {}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (client_end_.number() >= 0 && !link_.empty()) fs::remove(link_, ignored);
}

void PseudoTerminal::discard_output() {
  ::tcflush(client_end_.number(), TCIFLUSH);
}

}  // namespace stonestack::core
