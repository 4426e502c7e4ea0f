#include "emulators/camera/camera_simulator.hpp"

#include <chrono>
#include <cstring>
#include <limits>
#include <mutex>
#include <thread>

#include "emulators/tcp_service.hpp"
#include "protocol/frame_stream.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kIdle = 3600.0;  // s that a client may stay silent
constexpr double kSend = 5.0;     // s that a client may take to read a frame
constexpr std::size_t kLongestLine = 64;
constexpr std::size_t kFocalAt = 24, kUnitAt = 96, kPixelBytesAt = 120;  // bytes of the header

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

void put_double(std::vector<std::uint8_t>& bytes, std::size_t at, double value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);  // little-endian, as every supported platform
}

}  // namespace

IdealDepthPlant::IdealDepthPlant(const CameraIntrinsics& camera, double depth, double unit)
    : camera_(camera), depth_(depth), unit_(unit) {}

DepthFrame IdealDepthPlant::frame() {
  DepthFrame frame;
  frame.number = ++number_;
  frame.device_time = static_cast<double>(number_) / 30.0;
  frame.image.camera = camera_;
  const auto pixels = static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  for (std::size_t i = 0; i < pixels; ++i) {
    const bool raised = (i + static_cast<std::size_t>(number_)) % 7 == 0;
    frame.image.z.push_back(static_cast<float>(depth_ + (raised ? unit_ : 0.0)));
  }
  return frame;
}

FieldList fields(CameraFaults& o) {
  const FieldRange count{-1, 1e9};
  return {
      field("no_frame", o.no_frame, count, "", "requests that get nothing"),
      field("hang_up", o.hang_up, count, "", "requests at which the connection is closed"),
      field("truncated", o.truncated, count, "", "frames of which half is sent, then silence"),
      field("bad_crc", o.bad_crc, count, "", "frames with a flipped bit in the pixels"),
      field("garbage", o.garbage, count, "", "replies that are no frame"),
      field("wrong_size", o.wrong_size, count, "", "frames whose header does not fit the pixels"),
      field("not_finite", o.not_finite, count, "", "frames with NaN as focal length"),
      field("repeated", o.repeated, count, "", "frames sent once more: number, time and image"),
      field("frozen", o.frozen, count, "", "old images with a new number and time"),
      field("empty", o.empty, count, "", "frames without any depth"),
      field("scaled", o.scaled, count, "", "frames whose depth unit is a thousand times too small"),
      field("delayed", o.delayed, count, "", "frames that come late by `delay`"),
      field("delay", o.delay, {0.0, 60.0}, "s", "of delayed frames"),
  };
}

FieldList fields(CameraSimulatorOptions& o) {
  return {
      field("address", o.address, "any 127.x.y.z"),
      field("port", o.port, {0, 65535}, "", "0: a free one"),
      field("rate", o.rate, {0.1, 300.0}, "1/s", "of frames to clients that ask for a stream; SR300: 30"),
      field("unit", o.unit, {1e-6, 0.1}, "m", "of a depth count; SR300: 1/8 mm"),
  };
}

struct CameraSimulator::Parts {
  DepthPlant* plant;
  CameraSimulatorOptions options;
  std::mutex mutex;  // of all below and of the plant
  CameraFaults faults;
  DepthFrame last;
  std::unique_ptr<TcpService> service;

  Parts(DepthPlant& p, const CameraSimulatorOptions& o) : plant(&p), options(o) {}

  bool take(int CameraFaults::*fault) {
    int& left = faults.*fault;
    if (left == 0) return false;
    if (left > 0) --left;
    return true;
  }

  DepthFrame see() {
    if (last.number > 0 && take(&CameraFaults::repeated)) return last;
    DepthFrame frame = plant->frame();
    if (last.number > 0 && take(&CameraFaults::frozen)) frame.image = last.image;
    if (take(&CameraFaults::empty)) std::fill(frame.image.z.begin(), frame.image.z.end(), 0.0F);
    last = frame;
    return frame;
  }

  /// False: the client is to be sent away.
  bool serve_one(TcpStream& stream) {
    std::vector<std::uint8_t> bytes;
    double delay = 0.0;
    {
      const std::lock_guard lock(mutex);
      bytes = encode_frame(see(), options.unit);
      if (take(&CameraFaults::no_frame)) return true;
      if (take(&CameraFaults::hang_up)) return false;
      if (take(&CameraFaults::bad_crc)) bytes.back() ^= 0x04U;
      if (take(&CameraFaults::wrong_size)) bytes[kPixelBytesAt] ^= 0x10U;
      if (take(&CameraFaults::not_finite))
        put_double(bytes, kFocalAt, std::numeric_limits<double>::quiet_NaN());
      if (take(&CameraFaults::scaled)) put_double(bytes, kUnitAt, options.unit / 1000.0);
      if (take(&CameraFaults::garbage)) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0x55});
      if (take(&CameraFaults::truncated)) bytes.resize(bytes.size() / 2);
      if (take(&CameraFaults::delayed)) delay = faults.delay;
    }
    if (delay > 0) sleep_for(delay);
    return static_cast<bool>(stream.write_all(bytes, Deadline::in(kSend)));
  }

  void serve(TcpStream& stream) {
    for (;;) {
      const LineResult line = stream.read_line(kLongestLine, Deadline::in(kIdle));
      if (!line) return;
      if (line.line == "capture") {
        if (!serve_one(stream)) return;
      } else if (line.line == "stream") {
        while (!stream.is_shut() && serve_one(stream)) sleep_for(1.0 / options.rate);
        return;
      } else {
        return;  // not a known client
      }
    }
  }
};

CameraSimulator::CameraSimulator(DepthPlant& plant, const CameraSimulatorOptions& options)
    : parts_(std::make_unique<Parts>(plant, options)) {
  Parts& parts = *parts_;
  parts.service = std::make_unique<TcpService>(ListenOptions{options.address, options.port},
                                               [&parts](TcpStream& stream) { parts.serve(stream); });
}

CameraSimulator::~CameraSimulator() = default;

Endpoint CameraSimulator::endpoint() const {
  return parts_->service->endpoint();
}

void CameraSimulator::set_faults(const CameraFaults& faults) {
  const std::lock_guard lock(parts_->mutex);
  parts_->faults = faults;
}

}  // namespace stonestack::emulators
