#include "emulators/robotiq/modbus_server.hpp"

#include <array>
#include <chrono>

#include "emulators/logged_thread.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kModbusIdle = 3600.0;  // s that a client may stay silent
constexpr double kModbusSend = 2.0;     // s that a client may take to read a reply
constexpr double kGap = 0.05;           // s of silence that ends an unfinished RTU frame
constexpr std::size_t kMaxKept = 1024;  // bytes without a request among them
const modbus::Bytes kGarbage{0xDE, 0xAD, 0xBE, 0xEF, 0x00, 0x20, 0x4E, 0xFF, 0x13, 0x37, 0x00, 0x00};

void pause(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

template <class Stream>
bool send_bytes(Stream& stream, const modbus::Bytes& bytes, bool fragments) {
  const Deadline deadline = Deadline::in(kModbusSend);
  if (!fragments) return static_cast<bool>(stream.write_all(bytes, deadline));
  for (const auto byte : bytes) {
    if (!stream.write_all(modbus::View(&byte, 1), deadline)) return false;
    pause(0.0005);
  }
  return true;
}

}  // namespace

FieldList fields(ModbusFaults& o) {
  const FieldRange count{-1, 1e9};
  return {
      field("no_reply", o.no_reply, count, "", "requests carried out without a reply"),
      field("hang_up", o.hang_up, count, "", "requests at which the connection is closed (TCP)"),
      field("exceptions", o.exceptions, count, "", "requests refused with `exception`"),
      field("exception", o.exception, {1, 255}, "", "code of the refusals"),
      field("delayed", o.delayed, count, "", "replies that come late by `delay`"),
      field("delay", o.delay, {0.0, 60.0}, "s", "of delayed replies"),
      field("wrong_unit", o.wrong_unit, count, "", "replies by another unit"),
      field("wrong_transaction", o.wrong_transaction, count, "", "replies with another transaction id (TCP)"),
      field("wrong_count", o.wrong_count, count, "", "replies with a byte count that does not fit"),
      field("bad_crc", o.bad_crc, count, "", "replies with a flipped bit in the CRC (RTU)"),
      field("merged", o.merged, count, "", "replies behind another one in one piece"),
      field("truncated", o.truncated, count, "", "replies of which half is sent"),
      field("garbage", o.garbage, count, "", "replies that are no frame"),
      field("fragments", o.fragments, "true: replies come byte by byte"),
  };
}

void ModbusFaultBox::set(const ModbusFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

bool ModbusFaultBox::take(int ModbusFaults::*fault) {
  const std::lock_guard lock(mutex_);
  int& left = faults_.*fault;
  if (left == 0) return false;
  if (left > 0) --left;
  return true;
}

ModbusFaults ModbusFaultBox::now() {
  const std::lock_guard lock(mutex_);
  return faults_;
}

ModbusAnswer answer_modbus(modbus::View pdu, const ModbusHandler& handler, ModbusFaultBox& faults) {
  const std::uint8_t function = pdu.empty() ? std::uint8_t{0} : pdu[0];
  if (faults.take(&ModbusFaults::exceptions))
    return {modbus::exception_pdu(function, static_cast<modbus::Exception>(faults.now().exception))};
  const auto parsed = modbus::parse_request(pdu);
  if (const auto* problem = std::get_if<modbus::Exception>(&parsed))
    return {modbus::exception_pdu(function, *problem), false, true};
  const auto& request = std::get<modbus::Request>(parsed);
  const auto result = handler(request);
  ModbusAnswer answer;
  answer.silent = faults.take(&ModbusFaults::no_reply);
  if (const auto* refused = std::get_if<modbus::Exception>(&result)) {
    answer.pdu = modbus::exception_pdu(function, *refused);
    answer.refused = true;
    return answer;
  }
  answer.pdu = modbus::reply_pdu(request, std::get<std::vector<std::uint16_t>>(result));
  if (faults.take(&ModbusFaults::wrong_count)) ++answer.pdu.at(1);
  if (faults.take(&ModbusFaults::delayed)) pause(faults.now().delay);
  return answer;
}

ModbusTcpServer::ModbusTcpServer(const ListenOptions& options, ModbusHandler handler, ModbusFaultBox& faults)
    : handler_(std::move(handler)), faults_(&faults) {
  service_ = std::make_unique<TcpService>(options, [this](TcpStream& stream) { serve(stream); });
}

void ModbusTcpServer::serve(TcpStream& stream) {
  for (;;) {
    std::array<std::uint8_t, modbus::kTcpHeader> bytes;
    if (!stream.read_exact(bytes, Deadline::in(kModbusIdle))) return;
    const auto header = modbus::parse_tcp_header(bytes);
    if (!header) return;  // the framing is lost; only a new connection helps
    modbus::Bytes pdu(header->length - 1U);
    if (!stream.read_exact(pdu, Deadline::in(kModbusSend))) return;
    if (!reply(stream, *header, answer_modbus(pdu, handler_, *faults_))) return;
  }
}

bool ModbusTcpServer::reply(TcpStream& stream, const modbus::TcpHeader& header, const ModbusAnswer& answer) {
  if (answer.silent) return true;
  if (faults_->take(&ModbusFaults::hang_up)) return false;
  auto unit = header.unit;
  auto transaction = header.transaction;
  if (faults_->take(&ModbusFaults::wrong_unit)) ++unit;
  if (faults_->take(&ModbusFaults::wrong_transaction)) transaction ^= 0x5555U;
  modbus::Bytes frame = modbus::tcp_frame(transaction, unit, answer.pdu);
  if (faults_->take(&ModbusFaults::merged)) {
    const modbus::Bytes before =
        modbus::tcp_frame(static_cast<std::uint16_t>(transaction - 1), unit, answer.pdu);
    frame.insert(frame.begin(), before.begin(), before.end());
  }
  if (faults_->take(&ModbusFaults::truncated)) frame.resize(frame.size() / 2);
  if (faults_->take(&ModbusFaults::garbage)) frame = kGarbage;
  return send_bytes(stream, frame, faults_->now().fragments);
}

ModbusRtuServer::ModbusRtuServer(const std::string& link, int unit, ModbusHandler handler,
                                 ModbusFaultBox& faults)
    : line_(PseudoTerminal::open(link)),
      unit_(static_cast<std::uint8_t>(unit)),
      handler_(std::move(handler)),
      faults_(&faults),
      thread_(make_logged_thread("Modbus server at " + line_.path(), [this] { serve(); })) {}

ModbusRtuServer::~ModbusRtuServer() {
  line_.shut();
  thread_.join();
}

void ModbusRtuServer::serve() {
  modbus::Bytes kept;
  for (;;) {
    std::array<std::uint8_t, 256> part;
    const IoResult got = line_.read_some(part, Deadline::in(kept.empty() ? kModbusIdle : kGap));
    if (got.status == IoStatus::kClosed) return;
    if (got.status == IoStatus::kTimeOut || kept.size() > kMaxKept) kept.clear();
    kept.insert(kept.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(got.bytes));
    while (const auto frame = modbus::find_rtu_request(kept)) {
      kept.erase(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(frame->end));
      reply(*frame);
    }
  }
}

void ModbusRtuServer::reply(const modbus::RtuFrame& frame) {
  if (frame.unit != unit_) return;
  const ModbusAnswer answer = answer_modbus(frame.pdu, handler_, *faults_);
  if (answer.silent || answer.refused) return;
  const auto unit = static_cast<std::uint8_t>(unit_ + (faults_->take(&ModbusFaults::wrong_unit) ? 1 : 0));
  modbus::Bytes bytes = modbus::rtu_frame(unit, answer.pdu);
  if (faults_->take(&ModbusFaults::bad_crc)) bytes.back() ^= 0x01U;
  if (faults_->take(&ModbusFaults::merged)) {
    const modbus::Bytes half(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2));
    bytes.insert(bytes.begin(), half.begin(), half.end());
  }
  if (faults_->take(&ModbusFaults::truncated)) bytes.resize(bytes.size() / 2);
  if (faults_->take(&ModbusFaults::garbage)) bytes = kGarbage;
  if (!send_bytes(line_, bytes, faults_->now().fragments)) line_.discard_output();
}

}  // namespace stonestack::emulators
