#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stonestack/hardware/cell.hpp"

/// Private to stacking/: what the devices answered in a run, so that its decisions can be made again.
namespace stonestack::stacking {

/// Answers of devices, in order: "stonestack.inputs/1", one JSON object a line, and a file of 32-bit floats
/// for each depth image.
class DeviceTape {
 public:
  using Ask = std::function<nlohmann::json()>;
  virtual ~DeviceTape() = default;
  /// The answer to a call of that name: of `ask`, or the next one that was recorded.
  /// @throws DeviceError that the device threw, now or when it was recorded
  virtual nlohmann::json answer(const std::string& call, const Ask& ask) = 0;
  /// Keeps an image; its name stands for it.
  virtual std::string keep(const std::vector<float>& depths) = 0;
  /// The depths that `keep` gave that name to.
  virtual std::vector<float> depths(const std::string& name) = 0;
};

/// Writes answers into a folder, which it makes.
/// @throws FileError
[[nodiscard]] std::unique_ptr<DeviceTape> record_devices(const std::string& folder);

/// Gives recorded answers; asks no device.
class RecordedTape final : public DeviceTape {
 public:
  /// @throws FileError for a folder without a record, or one that holds something else.
  explicit RecordedTape(const std::string& folder);
  nlohmann::json answer(const std::string& call, const Ask& ask) override;
  std::string keep(const std::vector<float>& depths) override;
  std::vector<float> depths(const std::string& name) override;
  /// True once more was asked than is recorded.
  [[nodiscard]] bool ran_out() const { return ran_out_; }
  std::function<void()> at_end;  ///< called then, once

 private:
  std::string folder_;
  std::map<std::string, std::vector<nlohmann::json>> answers_;
  std::map<std::string, std::size_t> given_;
  std::mutex mutex_;  // the arm moves in a thread of its own
  bool ran_out_ = false;
};

/// Devices of a cell behind a tape.
class TapedDevices {
 public:
  /// Devices that are asked.
  TapedDevices(const Cell& cell, DeviceTape& tape);
  /// Recorded ones.
  TapedDevices(const CellLayout& layout, RecordedTape& tape);
  ~TapedDevices();
  /// Devices whose answers are those of the tape.
  [[nodiscard]] Cell cell();

 private:
  struct Devices;
  std::unique_ptr<Devices> devices_;
};

}  // namespace stonestack::stacking
