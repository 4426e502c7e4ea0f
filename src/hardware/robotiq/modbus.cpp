#include "hardware/robotiq/modbus.hpp"

#include "hardware/robotiq/modbus_transport.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {

FieldList fields(ModbusOptions& o) {
  return {
      field("link", o.link, "tcp or rtu"),
      user(field("address", o.address, "over TCP, or its name in the network")),
      field("port", o.port, {1, 65535}, "", "over TCP; the standard's is 502"),
      user(field("device", o.device, "over a serial line: its path")),
      field("unit", o.unit, {0, 255}, "", "Robotiq manual: 2 over TCP, 9 on a serial line"),
      field("reply_timeout", o.reply_timeout, {0.01, 10.0}, "s", "of each attempt"),
      field("attempts", o.attempts, {1, 10}, "", "of each request, the first one included"),
      field("quiet", o.quiet, {0.002, 0.5}, "s", "silence on a serial line before a request is repeated"),
  };
}

struct ModbusClient::Link {
  std::string name;
  ModbusOptions options;
  std::unique_ptr<ModbusTransport> transport;
  long repeated = 0;

  [[nodiscard]] modbus::Reply call(const modbus::Request& request);
};

namespace {

std::unique_ptr<ModbusTransport> make_transport(const std::string& name, const ModbusOptions& options) {
  require(options.link == "tcp" || options.link == "rtu", name, ": link must be tcp or rtu, got '",
          options.link, "'");
  return options.link == "tcp" ? make_modbus_tcp(options) : make_modbus_rtu(options);
}

bool may_pass(std::uint8_t exception) {
  return exception == static_cast<std::uint8_t>(modbus::Exception::kAcknowledge) ||
         exception == static_cast<std::uint8_t>(modbus::Exception::kBusy);
}

modbus::Request make_read(std::uint8_t function, int address, int count) {
  require(address >= 0 && count >= 1 && count <= modbus::kMaxRead && address + count <= 0x10000,
          "a read takes 1 to 125 registers below 65536, got ", count, " from ", address);
  return {function, static_cast<std::uint16_t>(address), static_cast<std::uint16_t>(count), {}};
}

}  // namespace

modbus::Reply ModbusClient::Link::call(const modbus::Request& request) {
  std::string problem, remedy;
  for (int attempt = 0; attempt < options.attempts; ++attempt) {
    if (attempt > 0) {
      ++repeated;
      transport->recover();
    }
    ModbusAttempt result;
    try {
      result = transport->exchange(request);
    } catch (const DeviceError& error) {  // the link could not be made again
      if (attempt + 1 < options.attempts) continue;
      throw DeviceError(name, error.what(), "switch the device on and try again");
    }
    if (result.reply && result.reply->kind == modbus::Reply::Kind::kDone) return *result.reply;
    problem = result.reply ? "exception " + modbus::exception_text(result.reply->exception) : result.problem;
    remedy = result.remedy;
    if (!result.reply) continue;
    const bool passes = may_pass(result.reply->exception);
    remedy = passes ? "see what else uses the gripper, then try again"
                    : "check the register layout (preset) of this gripper";
    if (!passes) break;
  }
  throw DeviceError(name,
                    concat("function ", static_cast<int>(request.function), " at register ", request.address,
                           ": ", problem),
                    remedy);
}

ModbusClient::ModbusClient(std::string name, const ModbusOptions& options) : link_(std::make_unique<Link>()) {
  const bool tcp = options.link == "tcp";
  link_->name = concat(name, " at ", tcp ? concat(options.address, ":", options.port) : options.device,
                       " unit ", options.unit);
  require(options.unit >= 0 && options.unit <= 255, link_->name, ": a unit id lies in 0..255");
  require(options.attempts >= 1, link_->name, ": at least one attempt is needed, got ", options.attempts);
  link_->options = options;
  try {
    link_->transport = make_transport(link_->name, options);
  } catch (const DeviceError& error) {
    throw DeviceError(name, error.what(),
                      tcp ? "see whether the gripper has a Modbus TCP module" : "see above");
  }
}

ModbusClient::~ModbusClient() = default;
ModbusClient::ModbusClient(ModbusClient&&) noexcept = default;

ModbusClient::Registers ModbusClient::read_holding(int address, int count) {
  return link_->call(make_read(modbus::kReadHolding, address, count)).registers;
}

ModbusClient::Registers ModbusClient::read_input(int address, int count) {
  return link_->call(make_read(modbus::kReadInput, address, count)).registers;
}

void ModbusClient::write_one(int address, std::uint16_t value) {
  require(address >= 0 && address <= 0xFFFF, "a register lies in 0..65535, not ", address);
  (void)link_->call({modbus::kWriteOne, static_cast<std::uint16_t>(address), 1, {value}});
}

void ModbusClient::write_many(int address, const Registers& values) {
  const int count = static_cast<int>(values.size());
  require(address >= 0 && count >= 1 && count <= modbus::kMaxWritten && address + count <= 0x10000,
          "a write takes 1 to 123 registers below 65536, got ", count, " from ", address);
  (void)link_->call(
      {modbus::kWriteMany, static_cast<std::uint16_t>(address), static_cast<std::uint16_t>(count), values});
}

const std::string& ModbusClient::name() const {
  return link_->name;
}
long ModbusClient::repeated() const {
  return link_->repeated;
}

}  // namespace stonestack::hardware
