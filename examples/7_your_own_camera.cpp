// A camera of one's own: implement capture(). This one drops every second row, as a cheap sensor might.
#include <cstdio>

#include "stonestack/stonestack.hpp"

namespace {

class HalfCamera : public stonestack::hardware::DepthCamera {
 public:
  explicit HalfCamera(DepthCamera& device) : device_(device) {}
  stonestack::hardware::DepthFrame capture() override {
    auto frame = device_.capture();
    const int width = frame.image.camera.width;
    for (int v = 1; v < frame.image.camera.height; v += 2)
      for (int u = 0; u < width; ++u)
        frame.image.z[static_cast<std::size_t>(v * width + u)] = 0.0F;  // no depth
    return frame;
  }

 private:
  DepthCamera& device_;
};

}  // namespace

int main() try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));
  const stonestack::RobotModel robot = stonestack::read_robot("ur10");
  stonestack::SimulatedCell world(catalogue.stones, stonestack::first_stones(3), robot,
                                  stonestack::CellLayout{});

  stonestack::Cell simulated = world.cell();
  HalfCamera camera(simulated.camera);
  const stonestack::DetectionModels models(catalogue.stones);
  const auto found = stonestack::detect_stones(camera.capture().image, models);
  std::printf("%zu of 3 stones found with every second row\n", found.detections.size());
  return found.detections.empty() ? 4 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
