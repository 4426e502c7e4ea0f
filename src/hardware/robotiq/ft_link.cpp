#include "hardware/robotiq/ft_link.hpp"

#include "core/serial.hpp"
#include "core/socket.hpp"
#include "hardware/constants.hpp"
#include "protocol/modbus_frame.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

// Robotiq's manual and driver: a sensor streams if bytes come within 80 ms; while it streams it answers
// nothing; half a second of 0xFF stops it.
constexpr std::size_t kJamBytes = 60;
constexpr double kAfterJam = 0.1, kReply = 0.3;  // s
constexpr std::uint16_t kOutputSelect = 410, kStreamOn = 0x0200, kFirmware = 500;
constexpr std::uint16_t kFirmwareWords = 3;
constexpr std::size_t kLastBytes = 32;

/// Reads until there is a reading or the deadline is over, however much comes; remembers what came.
bool listen(FtLink& link, modbus::Bytes& last, Deadline deadline) {
  do {
    std::array<std::uint8_t, 256> bytes;
    const IoResult got = link.stream->read_some(bytes, deadline);
    if (!got) return false;
    const auto part = std::span<const std::uint8_t>(bytes).first(got.bytes);
    last.insert(last.end(), part.begin(), part.end());
    if (last.size() > kLastBytes)
      last.erase(last.begin(), last.end() - static_cast<std::ptrdiff_t>(kLastBytes));
    link.parser.feed(part);
    if (link.parser.next()) return true;
  } while (!deadline.over());
  return false;
}

std::optional<modbus::Reply> ask(ByteStream& line, std::uint8_t unit, const modbus::Request& request,
                                 Deadline deadline) {
  (void)line.write_all(modbus::rtu_frame(unit, modbus::request_pdu(request)), deadline);
  for (modbus::Bytes kept;;) {
    std::array<std::uint8_t, 256> bytes;
    const IoResult got = line.read_some(bytes, deadline);
    if (!got) return std::nullopt;
    kept.insert(kept.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got.bytes));
    if (const auto frame = modbus::find_rtu_reply(kept, unit, request))
      return modbus::parse_reply(request, frame->pdu);
    if (kept.size() > 1024 || deadline.over()) return std::nullopt;
  }
}

// Stops whatever is sent, so that the sensor answers.
void silence(ByteStream& line, Deadline deadline) {
  const std::vector<std::uint8_t> jam(kJamBytes, 0xFF);
  (void)line.write_all(jam, deadline);
  std::array<std::uint8_t, 256> noise;
  for (const Deadline quiet = deadline.or_in(0.5 + kAfterJam); !quiet.over();)
    if (!line.read_some(noise, quiet.or_in(kAfterJam))) break;
  line.discard_input();
}

// "FTS-2.0.1": three letters and three numbers (Robotiq's driver).
std::string firmware_text(const std::vector<std::uint16_t>& words) {
  const auto letter = [](int byte) { return byte >= 0x20 && byte < 0x7F ? static_cast<char>(byte) : '?'; };
  return concat(letter(words[0] >> 8), letter(words[0] & 0xFF), letter(words[1] >> 8), "-", words[1] & 0xFF,
                ".", words[2] >> 8, ".", words[2] & 0xFF);
}

void start_stream(FtLink& link, const FtSensorOptions& options, Deadline deadline) {
  const auto unit = static_cast<std::uint8_t>(options.unit);
  silence(*link.stream, deadline);
  const auto firmware =
      ask(*link.stream, unit, {modbus::kReadHolding, kFirmware, kFirmwareWords, {}}, deadline.or_in(kReply));
  if (firmware && firmware->kind == modbus::Reply::Kind::kDone) {
    link.firmware = firmware_text(firmware->registers);
    if (link.firmware.front() != 'F')
      throw DeviceError(ft_name(options), "what answers there has firmware '" + link.firmware + "'",
                        "give the line of the force sensor; its firmware starts with F");
  }
  (void)ask(*link.stream, unit, {modbus::kWriteMany, kOutputSelect, 1, {kStreamOn}}, deadline.or_in(kReply));
  link.parser = FtParser(FtParser::Format::kSerial);
}

FtLink open_link(const FtSensorOptions& options, Deadline deadline) try {
  if (options.link == "serial")
    return {std::make_unique<SerialPort>(SerialPort::open(options.device, kSensorBaud)),
            FtParser(FtParser::Format::kSerial),
            {}};
  require(options.link == "ur_cap", "the link of a force sensor is serial or ur_cap, not '", options.link,
          "'");
  return {std::make_unique<TcpStream>(TcpStream::connect({options.address, options.port}, deadline)),
          FtParser(FtParser::Format::kCap),
          {}};
} catch (const DeviceError& error) {
  throw DeviceError(ft_name(options), error.what(),
                    options.link == "serial" ? "see force_torque.device in the cell file"
                                             : "see that the sensor's cap is installed on the controller");
}

}  // namespace

std::string ft_name(const FtSensorOptions& options) {
  return "Robotiq force sensor " + (options.link == "serial"
                                        ? "on " + options.device
                                        : "at " + to_text(Endpoint{options.address, options.port}));
}

FtLink start_ft_link(const FtSensorOptions& options, Deadline deadline) {
  if (options.link == "serial" && options.device.empty())
    throw DeviceError("force_torque.device", "is missing",
                      "give its path, see `ls /dev/serial/by-id`, or link: ur_cap with an address");
  FtLink link = open_link(options, deadline);
  modbus::Bytes last;
  if (options.link == "ur_cap") {
    if (listen(link, last, deadline)) return link;
  } else {
    while (!deadline.over()) {
      if (listen(link, last, deadline.or_in(options.listen))) return link;
      start_stream(link, options, deadline);
    }
  }
  throw DeviceError(
      ft_name(options),
      last.empty() ? std::string("sends nothing") : "sends no valid frame, last " + modbus::hex_text(last),
      options.link == "serial"
          ? concat("check power, the line, and ", kSensorBaud, " baud; unit ", options.unit)
          : "check that the sensor's cap is installed and the sensor is connected");
}

}  // namespace stonestack::hardware
