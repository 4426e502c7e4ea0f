#include "hardware/camera/stream_camera.hpp"

#include <array>

#include "core/socket.hpp"
#include "hardware/constants.hpp"
#include "protocol/frame_stream.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {

FieldList fields(StreamCameraOptions& o) {
  FieldList own = {
      user(field("address", o.address, "of the server, or its name in the network")),
      user(field("port", o.port, {0, 65535}, "", "of the server")),
      field("frame_timeout", o.frame_timeout, {0.05, 60.0}, "s", "until the next frame"),
      field("attempts", o.attempts, {1, 10}, "", "of a connection"),
  };
  return join({own, fields(o.check)});
}

struct StreamCamera::Link {
  StreamCameraOptions options;
  std::string name;
  FrameCheck check;
  std::unique_ptr<TcpStream> stream;

  explicit Link(const StreamCameraOptions& o)
      : options(o), name("depth camera at " + to_text({o.address, o.port})), check(name, o.check) {}

  void connect() {
    try {
      stream = std::make_unique<TcpStream>(
          TcpStream::connect({options.address, options.port}, Deadline::in(kConnectTimeout).or_interrupt()));
    } catch (const DeviceError& error) {
      throw DeviceError(name, error.what(), "start the camera's server");
    }
  }

  /// The next frame; empty with a problem when the link is not to be trusted any more.
  std::optional<DepthFrame> ask(std::string& problem) {
    const Deadline deadline = Deadline::in(options.frame_timeout).or_interrupt();
    const auto lost = [&](IoStatus status) {
      problem = status == IoStatus::kClosed ? "the connection was closed"
                                            : concat("no frame within ", options.frame_timeout, " s");
      return std::nullopt;
    };
    if (const IoResult sent = stream->write_all("capture\n", deadline); !sent) return lost(sent.status);
    std::array<std::uint8_t, kFrameHeader> bytes;
    if (const IoResult got = stream->read_exact(bytes, deadline); !got) return lost(got.status);
    const auto header = parse_frame_header(bytes, problem);
    if (!header) return std::nullopt;
    std::vector<std::uint8_t> pixels(header->pixel_bytes);
    if (const IoResult got = stream->read_exact(pixels, deadline); !got) return lost(got.status);
    auto frame = parse_frame(*header, pixels);
    if (!frame) problem = "the pixels do not match their checksum";
    return frame;
  }
};

StreamCamera::StreamCamera(const StreamCameraOptions& options) : link_(std::make_unique<Link>(options)) {
  link_->connect();
}
StreamCamera::~StreamCamera() = default;

DepthFrame StreamCamera::capture() {
  std::string problem;
  for (int attempt = 0; attempt < link_->options.attempts; ++attempt) {
    throw_if_interrupted();
    if (!link_->stream) {
      link_->connect();
      link_->check.restarted();
    }
    if (auto frame = link_->ask(problem)) return link_->check.pass(std::move(*frame));
    link_->stream.reset();
  }
  throw DeviceError(link_->name, problem, "look at the camera and start its server again");
}

}  // namespace stonestack::hardware
