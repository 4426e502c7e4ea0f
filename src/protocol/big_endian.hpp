#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

/// Big-endian numbers in strings of bytes, as every UR port sends them.
namespace stonestack::protocol {

template <std::size_t kBytes>
void put_unsigned(std::string& out, std::uint64_t value) {
  for (std::size_t i = kBytes; i-- > 0;) out.push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
}

inline void put(std::string& out, bool value) {
  put_unsigned<1>(out, value ? 1 : 0);
}
inline void put(std::string& out, std::uint8_t value) {
  put_unsigned<1>(out, value);
}
inline void put(std::string& out, std::uint16_t value) {
  put_unsigned<2>(out, value);
}
inline void put(std::string& out, std::uint32_t value) {
  put_unsigned<4>(out, value);
}
inline void put(std::string& out, std::uint64_t value) {
  put_unsigned<8>(out, value);
}
inline void put(std::string& out, std::int32_t value) {
  put(out, static_cast<std::uint32_t>(value));
}
inline void put(std::string& out, double value) {
  put(out, std::bit_cast<std::uint64_t>(value));
}
template <class T, std::size_t kCount>
void put(std::string& out, const std::array<T, kCount>& values) {
  for (const T& value : values) put(out, value);
}

/// Takes numbers off the front of bytes. Reading past the end gives zeros and makes `sound()` false for good.
class BigEndianReader {
 public:
  explicit BigEndianReader(std::string_view bytes) : rest_(bytes) {}
  [[nodiscard]] bool sound() const { return sound_; }
  /// Sound and nothing left.
  [[nodiscard]] bool finished() const { return sound_ && rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

  std::string_view take(std::size_t count) {
    if (count > rest_.size()) {
      sound_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }

  void get(bool& value) { value = take_unsigned(1) != 0; }
  void get(std::uint8_t& value) { value = static_cast<std::uint8_t>(take_unsigned(1)); }
  void get(std::uint16_t& value) { value = static_cast<std::uint16_t>(take_unsigned(2)); }
  void get(std::uint32_t& value) { value = static_cast<std::uint32_t>(take_unsigned(4)); }
  void get(std::uint64_t& value) { value = take_unsigned(8); }
  void get(std::int32_t& value) { value = static_cast<std::int32_t>(take_unsigned(4)); }
  void get(double& value) { value = std::bit_cast<double>(take_unsigned(8)); }
  template <class T, std::size_t kCount>
  void get(std::array<T, kCount>& values) {
    for (T& value : values) get(value);
  }
  template <class T>
  T get() {
    T value{};
    get(value);
    return value;
  }

 private:
  std::uint64_t take_unsigned(std::size_t count) {
    std::uint64_t value = 0;
    for (const char byte : take(count)) value = value << 8 | static_cast<unsigned char>(byte);
    return value;
  }

  std::string_view rest_;
  bool sound_ = true;
};

}  // namespace stonestack::protocol
