#include "core/serial.hpp"

#include <gmock/gmock.h>
#include <termios.h>

#include <array>
#include <filesystem>
#include <vector>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::core {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Bytes = std::vector<std::uint8_t>;

constexpr double kSoon = 0.02, kLong = 10.0;  // s

TEST(Serial, EveryByteGoesThroughUnchangedBothWays) {
  PseudoTerminal device = PseudoTerminal::open();
  SerialPort port = SerialPort::open(device.path(), 115200);
  Bytes all(256);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
  Bytes got(256);
  ASSERT_TRUE(port.write_all(all, Deadline::in(kLong)));
  ASSERT_TRUE(device.read_exact(got, Deadline::in(kLong)));
  EXPECT_EQ(got, all);
  ASSERT_TRUE(device.write_all(all, Deadline::in(kLong)));
  ASSERT_TRUE(port.read_exact(got, Deadline::in(kLong)));
  EXPECT_EQ(got, all);
}

TEST(Serial, SetsRateAndFraming) {
  PseudoTerminal device = PseudoTerminal::open();
  const SerialPort port = SerialPort::open(device.path(), 19200);
  termios settings{};
  ASSERT_EQ(::tcgetattr(port.descriptor(), &settings), 0);
  EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B19200));
  EXPECT_EQ(settings.c_cflag & (CSIZE | PARENB | CSTOPB), static_cast<tcflag_t>(CS8));
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), 0U);
}

TEST(Serial, TimesOutAndSeesAHangUp) {
  auto device = std::make_unique<PseudoTerminal>(PseudoTerminal::open());
  SerialPort port = SerialPort::open(device->path(), 9600);
  Bytes got(1);
  EXPECT_EQ(port.read_some(got, Deadline::in(kSoon)).status, IoStatus::kTimeOut);
  device.reset();
  EXPECT_EQ(port.read_some(got, Deadline::in(kLong)).status, IoStatus::kClosed);
}

TEST(Serial, ShutWakesAReaderOfATty) {
  PseudoTerminal device = PseudoTerminal::open();
  device.shut();
  Bytes got(1);
  EXPECT_EQ(device.read_some(got, Deadline::in(60)).status, IoStatus::kClosed);
}

TEST(Serial, ClientsComeAndGo) {
  PseudoTerminal device = PseudoTerminal::open();
  Bytes got(1);
  for (const char* text : {"a", "b"}) {
    SerialPort port = SerialPort::open(device.path(), 115200);
    ASSERT_TRUE(port.write_all(text, Deadline::in(kLong)));
    ASSERT_TRUE(device.read_exact(got, Deadline::in(kLong)));
    EXPECT_EQ(got[0], static_cast<std::uint8_t>(text[0]));
  }
}

TEST(Serial, KeepsNothingForALateReader) {
  PseudoTerminal device = PseudoTerminal::open();
  ASSERT_TRUE(device.write_all("stale", Deadline::in(kLong)));
  device.discard_output();
  SerialPort port = SerialPort::open(device.path(), 115200);
  Bytes got(5);
  EXPECT_EQ(port.read_some(got, Deadline::in(kSoon)).status, IoStatus::kTimeOut);
}

TEST(Serial, TwoOwnersAreRefused) {
  PseudoTerminal device = PseudoTerminal::open();
  const SerialPort first = SerialPort::open(device.path(), 115200);
  EXPECT_THAT([&] { (void)SerialPort::open(device.path(), 115200); },
              ThrowsMessage<DeviceError>(HasSubstr(device.path() + ": is in use")));
}

TEST(Serial, NamesTheFaultOfThePath) {
  EXPECT_THAT([] { (void)SerialPort::open("/dev/ttyNothing", 115200); },
              ThrowsMessage<DeviceError>(HasSubstr("/dev/ttyNothing: cannot be opened")));
  const std::string file = test::temporary_folder() + "serial_test_file";
  write_file(file, "x");
  EXPECT_THAT([&] { (void)SerialPort::open(file, 115200); },
              ThrowsMessage<DeviceError>(HasSubstr("is not a serial line")));
  fs::remove(file);
  PseudoTerminal device = PseudoTerminal::open();
  EXPECT_THROW((void)SerialPort::open(device.path(), 12345), InvalidArgument);
}

TEST(Serial, ALinkLivesAsLongAsTheTerminal) {
  const std::string link = test::temporary_folder() + "serial_test_link";
  fs::remove(link);
  {
    PseudoTerminal device = PseudoTerminal::open(link);
    EXPECT_EQ(fs::read_symlink(link), device.path());
    EXPECT_NO_THROW((void)SerialPort::open(link, 19200));
    EXPECT_THROW((void)PseudoTerminal::open(link), DeviceError) << "a link in use must not be replaced";
    EXPECT_TRUE(fs::is_symlink(link));
  }
  EXPECT_FALSE(fs::is_symlink(link));
  fs::create_symlink("/dev/pts/gone", link);
  EXPECT_NO_THROW((void)PseudoTerminal::open(link));
}

}  // namespace
}  // namespace stonestack::core
