#pragma once
#include <memory>

#include "core/byte_stream.hpp"
#include "hardware/robotiq/ft_sensor.hpp"
#include "protocol/ft_frames.hpp"

namespace stonestack::hardware {

/// Opens the sensor's link and leaves it streaming.
struct FtLink {
  std::unique_ptr<ByteStream> stream;
  FtParser parser;
  std::string firmware;
};
/// Throws DeviceError with the last bytes when no reading comes before the deadline.
[[nodiscard]] FtLink start_ft_link(const FtSensorOptions& options, Deadline deadline);
/// "Robotiq force sensor on /dev/ttyUSB0".
[[nodiscard]] std::string ft_name(const FtSensorOptions& options);

}  // namespace stonestack::hardware
