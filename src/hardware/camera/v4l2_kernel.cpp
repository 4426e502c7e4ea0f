#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <ctime>

#include "hardware/camera/v4l2_calls.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

class Kernel final : public V4l2Calls {
 public:
  explicit Kernel(Descriptor node) : node_(std::move(node)) {}
  int control(unsigned long request, void* argument) override {
    int result = 0;
    do result = ::ioctl(node_.number(), request, argument);
    while (result < 0 && errno == EINTR);
    return result;
  }
  void* map(std::size_t length, off_t offset) override {
    void* start = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, node_.number(), offset);
    return start == MAP_FAILED ? nullptr : start;
  }
  void unmap(void* address, std::size_t length) override { ::munmap(address, length); }
  bool wait(Deadline deadline) override {
    for (;;) {
      pollfd watched{node_.number(), POLLIN, 0};
      const int ready = ::poll(&watched, 1, static_cast<int>(deadline.turn() * 1e3) + 1);
      if (ready > 0) return true;
      if (deadline.over()) return false;
    }
  }
  double now() override {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

 private:
  Descriptor node_;
};

}  // namespace

std::unique_ptr<V4l2Calls> open_v4l2(const std::string& device) {
  Descriptor node(::open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (node.number() < 0)
    throw DeviceError("depth camera " + device, "cannot be opened: " + std::string(std::strerror(errno)),
                      errno == EACCES ? "join the group video" : "see `v4l2-ctl --list-devices`");
  return std::make_unique<Kernel>(std::move(node));
}

}  // namespace stonestack::hardware
