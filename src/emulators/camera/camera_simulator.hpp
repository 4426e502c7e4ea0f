#pragma once
#include <memory>
#include <string>

#include "core/socket.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/hardware/devices.hpp"

namespace stonestack::simulation {
class SharedWorld;
}

namespace stonestack::emulators {

/// Source of a simulated depth camera's images.
class DepthPlant {
 public:
  virtual ~DepthPlant() = default;
  /// A frame exposed after the call. Called by one thread at a time.
  virtual DepthFrame frame() = 0;
};

/// A plane with noise of a count, so that no two frames are equal.
class IdealDepthPlant final : public DepthPlant {
 public:
  /// Depth of the plane and metres a count.
  IdealDepthPlant(const CameraIntrinsics& camera, double depth, double unit);
  DepthFrame frame() override;

 private:
  CameraIntrinsics camera_;
  double depth_, unit_;
  long number_ = 0;
};

/// The camera of a simulated cell with its sensor's noise. The world stands still only while poses are
/// copied. The world must outlive it.
[[nodiscard]] std::unique_ptr<DepthPlant> make_world_depth(SharedWorld& world);

/// Faults of a simulated depth camera. Counts: frames from now on, -1 all.
struct CameraFaults {
  int no_frame = 0;    ///< nothing is sent
  int hang_up = 0;     ///< the connection is closed
  int truncated = 0;   ///< half a frame, then silence
  int bad_crc = 0;     ///< a flipped bit in the pixels
  int garbage = 0;     ///< bytes that are no frame
  int wrong_size = 0;  ///< a header whose size does not fit the pixels
  int not_finite = 0;  ///< NaN as focal length
  int repeated = 0;    ///< the frame before once more: number, time and image
  int frozen = 0;      ///< the image before with a new number and time
  int empty = 0;       ///< no depth anywhere
  int scaled = 0;      ///< depth unit a thousand times too small
  int delayed = 0;     ///< late by `delay`
  double delay = 1.0;  ///< [s]
};
[[nodiscard]] FieldList fields(CameraFaults& faults);

struct CameraSimulatorOptions {
  std::string address = "127.0.0.1";  ///< any 127.x.y.z
  int port = 0;                       ///< 0: a free one
  double rate = 30.0;                 ///< frames/s to clients that asked for a stream
  double unit = 0.000125;             ///< metres per count (SR300)
};
[[nodiscard]] FieldList fields(CameraSimulatorOptions& options);

/// Serves depth frames over TCP (src/protocol/frame_stream.hpp) to any number of clients.
class CameraSimulator {
 public:
  /// `plant` must outlive the simulator. Throws as TcpListener does.
  explicit CameraSimulator(DepthPlant& plant, const CameraSimulatorOptions& options = {});
  ~CameraSimulator();
  [[nodiscard]] Endpoint endpoint() const;
  void set_faults(const CameraFaults& faults);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::emulators
