#pragma once
#include <memory>
#include <string>

#include "hardware/camera/camera_settings.hpp"

namespace stonestack::hardware {

struct StreamCameraOptions {
  std::string address = "127.0.0.1";
  int port = 0;
  double frame_timeout = 3.0;  ///< from asking to the last byte [s]
  int attempts = 2;            ///< per frame; each after the first on a new connection
  FrameCheckOptions check;
};
[[nodiscard]] FieldList fields(StreamCameraOptions& options);

/// A depth camera behind a TCP socket, such as the simulated one; the wire format is described in
/// src/protocol/frame_stream.hpp. Intrinsics and depth unit come with each frame.
class StreamCamera final : public DepthCamera {
 public:
  /// Throws DeviceError when nobody listens there.
  explicit StreamCamera(const StreamCameraOptions& options);
  ~StreamCamera() override;
  /// Asks for a frame exposed from now on.
  /// @throws DeviceError that names the address: no frame before the deadline, a damaged one (after
  /// `attempts`), and what FrameCheck refuses.
  [[nodiscard]] DepthFrame capture() override;

 private:
  struct Link;
  std::unique_ptr<Link> link_;
};

}  // namespace stonestack::hardware
