#include "emulators/ur/primary_messages.hpp"

#include <bit>

#include "protocol/big_endian.hpp"

namespace stonestack::emulators {
namespace {

constexpr std::uint8_t kRobotMessage = 20;
constexpr std::uint8_t kSourceInterface = 0xFE, kSourceMachine = 0xFD;  // -2, -3
constexpr std::uint8_t kText = 0, kPopup = 2, kVersion = 3, kSafety = 5, kError = 6, kKey = 7,
                       kException = 10;

// The length is what precedes everything, itself included.
std::string framed(const std::string& body) {
  std::string message;
  put(message, static_cast<std::uint32_t>(body.size() + 4));
  return message + body;
}

std::string message(const UrController& controller, std::uint8_t source, std::uint8_t kind) {
  std::string body;
  put(body, kRobotMessage);
  put(body, static_cast<std::uint64_t>(controller.timestamp() * 1e9));
  put(body, source);
  put(body, kind);
  return body;
}

void put_short_text(std::string& body, const std::string& text) {
  const auto length = static_cast<std::uint8_t>(std::min<std::size_t>(text.size(), 255));
  put(body, length);
  body += text.substr(0, length);
}

void put_int(std::string& body, int value) {
  put(body, static_cast<std::int32_t>(value));
}

}  // namespace

std::string encode_version_message(const UrController& controller) {
  const UrVersion& version = controller.version();
  std::string body = message(controller, kSourceInterface, kVersion);
  put_short_text(body, "URControl");
  put(body, static_cast<std::uint8_t>(version.major));
  put(body, static_cast<std::uint8_t>(version.minor));
  put(body, version.bugfix);
  put(body, version.build);
  return framed(body + "01-01-2024, 00:00:00");
}

ControllerEvent read_only_error() {
  ControllerEvent event;
  event.kind = ControllerEvent::Kind::kErrorCode;
  event.code = 210;
  event.level = 2;  // warning
  event.text = "Script received on a read-only interface";
  return event;
}

std::string encode_event(const UrController& controller, const ControllerEvent& event) {
  using Kind = ControllerEvent::Kind;
  std::string body;
  switch (event.kind) {
    case Kind::kKey:
      body = message(controller, kSourceInterface, kKey);
      put_int(body, event.code);
      put_int(body, event.argument);
      put_short_text(body, event.title);
      return framed(body + event.text);
    case Kind::kText:
      return framed(message(controller, kSourceMachine, kText) + event.text);
    case Kind::kRuntimeException:
      body = message(controller, kSourceMachine, kException);
      put_int(body, event.line);
      put_int(body, event.column);
      return framed(body + event.text);
    case Kind::kErrorCode:
      body = message(controller, kSourceInterface, kError);
      put_int(body, event.code);
      put_int(body, event.argument);
      put_int(body, event.level);
      put(body, std::uint32_t{0});
      put(body, std::uint32_t{0});
      return framed(body + event.text);
    case Kind::kSafetyMode:
      body = message(controller, kSourceInterface, kSafety);
      put_int(body, 0);
      put_int(body, 0);
      put(body, static_cast<std::uint8_t>(event.code));
      put(body, std::uint32_t{0});
      put(body, std::uint32_t{0});
      return framed(body);
    case Kind::kPopup:
      body = message(controller, kSourceMachine, kPopup);
      put(body, std::uint32_t{0});
      put(body, std::uint8_t{0});
      put(body, event.warning);
      put(body, event.error);
      put(body, event.blocking);
      put_short_text(body, event.title);
      return framed(body + event.text);
  }
  return {};
}

}  // namespace stonestack::emulators
