#include "hardware/robotiq/modbus.hpp"

#include <gmock/gmock.h>
#include <modbus/modbus.h>

#include <array>
#include <atomic>
#include <thread>

#include "core/serial.hpp"
#include "core/socket.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Registers = ModbusClient::Registers;

constexpr int kHolding = 20, kInput = 12;

/// libmodbus as the slave: holding registers 0.. and input registers 0.., input i holds 100 + i.
class ForeignSlave {
 public:
  explicit ForeignSlave(modbus_t* context)
      : context_(context), map_(modbus_mapping_new(0, 0, kHolding, kInput)) {
    for (int i = 0; i < kInput; ++i) map_->tab_input_registers[i] = static_cast<std::uint16_t>(100 + i);
  }
  ~ForeignSlave() {
    modbus_mapping_free(map_);
    modbus_close(context_);
    modbus_free(context_);
  }
  ForeignSlave(const ForeignSlave&) = delete;
  ForeignSlave& operator=(const ForeignSlave&) = delete;

  /// Serves until `stop` is set or the master leaves.
  void serve(const std::atomic<bool>& stop) {
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> query;
    modbus_set_indication_timeout(context_, 0, 50000);
    while (!stop) {
      const int length = modbus_receive(context_, query.data());
      if (length > 0) modbus_reply(context_, query.data(), length, map_);
      if (length < 0 && errno != ETIMEDOUT) return;
    }
  }

 private:
  modbus_t* context_;
  modbus_mapping_t* map_;
};

void check_all_functions(ModbusClient& client) {
  client.write_many(3, {0x1234, 0xFFFF, 0});
  EXPECT_EQ(client.read_holding(2, 5), (Registers{0, 0x1234, 0xFFFF, 0, 0}));
  client.write_one(19, 77);
  EXPECT_EQ(client.read_holding(19, 1), Registers{77});
  EXPECT_EQ(client.read_input(10, 2), (Registers{110, 111}));
  EXPECT_THAT([&] { (void)client.read_holding(18, 3); },
              ThrowsMessage<DeviceError>(HasSubstr("exception 2 (illegal data address)")));
  EXPECT_EQ(client.read_input(0, 1), Registers{100}) << "an exception must not spoil the link";
  EXPECT_EQ(client.repeated(), 0);
}

TEST(ModbusClient, TalksToLibmodbusOverTcp) {
  int port = 0;
  {
    const TcpListener free_port{ListenOptions{}};
    port = free_port.endpoint().port;
  }
  modbus_t* context = modbus_new_tcp("127.0.0.1", port);
  ForeignSlave slave(context);
  int listening = modbus_tcp_listen(context, 1);
  ASSERT_GE(listening, 0);
  std::atomic<bool> stop = false;
  std::thread server([&] {
    modbus_tcp_accept(context, &listening);
    slave.serve(stop);
  });
  {
    ModbusOptions options;
    options.port = port;
    options.reply_timeout = 5.0;
    ModbusClient client("slave", options);
    EXPECT_EQ(client.name(), concat("slave at 127.0.0.1:", port, " unit 2"));
    check_all_functions(client);
  }
  stop = true;
  server.join();
}

TEST(ModbusClient, TalksToLibmodbusOverASerialLine) {
  // Two pseudo terminals back to back: libmodbus opens one, we the other.
  PseudoTerminal theirs = PseudoTerminal::open(), own = PseudoTerminal::open();
  std::atomic<bool> stop = false;
  const auto copy = [&stop](ByteStream& from, ByteStream& to) {
    std::array<std::uint8_t, 256> bytes;
    while (!stop) {
      const IoResult got = from.read_some(bytes, Deadline::in(0.05));
      if (got && !to.write_all(std::span(bytes).first(got.bytes), Deadline::in(1))) return;
    }
  };
  modbus_t* context = modbus_new_rtu(theirs.path().c_str(), 115200, 'N', 8, 1);
  ForeignSlave slave(context);
  modbus_set_slave(context, 9);
  ASSERT_EQ(modbus_connect(context), 0);
  std::thread there([&] { copy(own, theirs); }), back([&] { copy(theirs, own); });
  std::thread server([&] { slave.serve(stop); });
  {
    ModbusOptions options;
    options.link = "rtu";
    options.device = own.path();
    options.unit = 9;
    options.reply_timeout = 5.0;
    ModbusClient client("slave", options);
    check_all_functions(client);
  }
  stop = true;
  server.join();
  there.join();
  back.join();
}

TEST(ModbusClient, AMissingDeviceIsNamed) {
  ModbusOptions options;
  {
    const TcpListener free_port{ListenOptions{}};
    options.port = free_port.endpoint().port;
  }
  EXPECT_THAT(
      [&] { ModbusClient("Robotiq gripper", options); },
      ThrowsMessage<DeviceError>(AllOf(HasSubstr("Robotiq gripper"), HasSubstr(std::to_string(options.port)),
                                       HasSubstr("connection refused"))));
  options.link = "rtu";
  options.device = "/dev/ttyNothing";
  EXPECT_THAT([&] { ModbusClient("Robotiq gripper", options); },
              ThrowsMessage<DeviceError>(HasSubstr("/dev/ttyNothing: cannot be opened")));
  options.link = "udp";
  EXPECT_THROW(ModbusClient("Robotiq gripper", options), InvalidArgument);
}

TEST(ModbusClient, RefusesRequestsThatTheProtocolCannotCarry) {
  const TcpListener listener{ListenOptions{}};
  ModbusOptions options;
  options.port = listener.endpoint().port;
  ModbusClient client("slave", options);
  EXPECT_THROW((void)client.read_holding(0, 126), InvalidArgument);
  EXPECT_THROW((void)client.read_holding(0, 0), InvalidArgument);
  EXPECT_THROW((void)client.read_input(65535, 2), InvalidArgument);
  EXPECT_THROW((void)client.read_input(-1, 1), InvalidArgument);
  EXPECT_THROW(client.write_many(0, {}), InvalidArgument);
  EXPECT_THROW(client.write_many(0, Registers(124)), InvalidArgument);
  EXPECT_THROW(client.write_one(65536, 1), InvalidArgument);
}

TEST(ModbusClient, AServerThatAcceptsAndKeepsSilentEndsAtTheDeadline) {
  const TcpListener listener{ListenOptions{}};
  ModbusOptions options;
  options.port = listener.endpoint().port;
  options.reply_timeout = 0.02;
  ModbusClient client("slave", options);
  EXPECT_THAT([&] { (void)client.read_input(0, 8); },
              ThrowsMessage<DeviceError>(HasSubstr("no reply within 0.02 s")));
  EXPECT_EQ(client.repeated(), 2);
}

}  // namespace
}  // namespace stonestack::hardware
