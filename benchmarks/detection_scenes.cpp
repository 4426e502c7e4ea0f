#include "detection_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/constants.hpp"
#include "physics/world.hpp"

namespace stonestack::bench {
namespace {

constexpr double kApart = 0.001;       // m, between stones that "touch"
constexpr double kHeapRadius = 0.07;   // m from the middle of a heap to where a stone is let go, at most
constexpr double kHeapFriction = 0.6;  // of dry limestone on limestone, about
constexpr double kHeapRest = 0.6;      // s that a stone is given before the next one

double lowest(const Stone& stone, const Eigen::Quaterniond& R) {
  double z = 1e9;
  for (const auto& p : stone.mesh.vertices) z = std::min(z, (R * p).z());
  return z;
}

/// A camera 0.6 to 0.8 m from the middle of the scene, `tilt` off the vertical.
Pose camera_pose(double tilt, double azimuth, Random& random) {
  const double distance = random.uniform(0.62, 0.78);
  const Eigen::Vector3d out(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                            std::cos(tilt));
  Eigen::Matrix3d R;
  R.col(2) = -out;
  R.col(0) = R.col(2).cross(Eigen::Vector3d(-std::sin(azimuth), std::cos(azimuth), 0.2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  const Eigen::Vector3d target(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.05);
  return make_pose(target + distance * out, Eigen::Quaterniond(R));
}

/// The pose as an arm with a calibration error would report it.
Pose reported(const Pose& T_W_C, const CameraError& error, Random& random) {
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(random.normal(0, sigma), random.normal(0, sigma), random.normal(0, sigma));
  };
  Pose off = make_pose(noise(error.shift));
  const Eigen::Vector3d turn = noise(error.turn);
  if (turn.norm() > 0) off.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return T_W_C * off;
}

/// Left for right, as a wrong sign in a driver gives it.
void mirror(DepthImage& image) {
  const int width = image.camera.width;
  image.camera.cx = width - 1 - image.camera.cx;
  for (auto row = image.z.begin(); row != image.z.end(); row += width) std::reverse(row, row + width);
}

std::size_t pixels_of(const RenderedView& view, int instance) {
  return static_cast<std::size_t>(std::count(view.instance.begin(), view.instance.end(), instance));
}

}  // namespace

std::vector<SceneKind> scene_kinds() {
  return {{"isolated"},
          {"touching", 4, "touching"},
          {"stacked", 4, "stacked", "sr300", 1, 1, 0.5, 1.1},
          {"few", 1},
          {"d435", 4, "apart", "d435"},
          {"copies", 4, "apart", "sr300", 2},
          {"mirrored", 4, "apart", "sr300", 1, 1, 0.0, 0.78, 0.25, true},
          {"hidden", 6, "touching", "sr300", 1, 1, 1.2, 1.35, 0.0},
          {"two_views", 6, "touching", "sr300", 1, 2, 1.2, 1.35, 0.0}};
}

SceneMaker::SceneMaker(const std::vector<Stone>& stones) : stones_(stones) {
  for (const auto& s : stones) distance_.emplace_back(s.mesh, 0.004, 0.03);
}

double SceneMaker::gap(StoneIndex a, const Pose& T_W_A, StoneIndex b, const Pose& T_W_B) const {
  const auto one_way = [&](StoneIndex from, const Pose& T_from, StoneIndex to, const Pose& T_to) {
    const auto& field = at(distance_, to);
    const Pose T = T_to.inverse() * T_from;
    double nearest = field.band();
    for (const auto& p : at(stones_, from).mesh.vertices) nearest = std::min(nearest, field.distance(T * p));
    return nearest;
  };
  return std::min(one_way(a, T_W_A, b, T_W_B), one_way(b, T_W_B, a, T_W_A));
}

double SceneMaker::gap(const std::vector<PlacedStone>& placed, StoneIndex stone, const Pose& T_W_O) const {
  double nearest = 0.03;
  for (const auto& p : placed) nearest = std::min(nearest, gap(p.stone, p.T_W_O, stone, T_W_O));
  return nearest;
}

Eigen::Quaterniond SceneMaker::rest(StoneIndex stone, Random& random) const {
  const Stone& s = at(stones_, stone);
  Eigen::Quaterniond R = random.rotation();
  double height = -lowest(s, R);  // of the origin above the table: falls until the stone rests
  for (double step = 0.3; step > 0.004; step *= 0.97) {
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(step * random.uniform(), random.unit_vector()) * R);
    if (const double h = -lowest(s, turned); h < height) height = h, R = turned;
  }
  return R;
}

Pose SceneMaker::push(const std::vector<PlacedStone>& placed, StoneIndex stone, Pose T_W_O,
                      const Eigen::Vector3d& towards) const {
  for (double step = 0.016; step > 0.0005; step *= 0.5)
    for (int k = 0; k < 40; ++k) {
      const Pose next = make_pose(step * towards) * T_W_O;
      const double foot =
          next.translation().z() + lowest(at(stones_, stone), Eigen::Quaterniond(next.linear()));
      if (foot < -1e-6 || gap(placed, stone, next) < kApart) break;
      T_W_O = next;
    }
  return T_W_O;
}

std::vector<PlacedStone> SceneMaker::pile_up(const std::vector<StoneIndex>& order, Random& random) const {
  WorldOptions options;
  options.friction = kHeapFriction;
  World world(options);
  std::vector<PlacedStone> placed;
  for (const StoneIndex stone : order) {
    const double angle = random.uniform(0, 2 * kPi), r = kHeapRadius * std::sqrt(random.uniform());
    const Pose above = make_pose({r * std::cos(angle), r * std::sin(angle), 0.5}, random.rotation());
    placed.push_back({stone, push(placed, stone, above, -Eigen::Vector3d::UnitZ())});
    world.add_stone(
        make_contact_shape(at(stones_, stone).scan, at(stones_, stone).mass, at(stones_, stone).name),
        placed.back().T_W_O);
    world.run(kHeapRest);
    for (std::size_t k = 0; k < placed.size(); ++k) placed[k].T_W_O = world.pose(static_cast<int>(k));
  }
  return placed;
}

std::vector<PlacedStone> SceneMaker::arrange(const SceneKind& kind, Random& random) const {
  std::vector<StoneIndex> order = first_stones(stones_.size());
  random.shuffle(order.begin(), order.end());
  order.insert(order.begin(), static_cast<std::size_t>(kind.copies - 1), order.front());
  std::vector<PlacedStone> placed;
  const int count = std::min<int>(kind.present, static_cast<int>(order.size()));
  if (kind.arrangement == "heap") return pile_up({order.begin(), order.begin() + count}, random);
  const double start = random.uniform(0, 2 * kPi);
  for (int i = 0; i < count; ++i) {
    const StoneIndex stone = order[static_cast<std::size_t>(i)];
    const Eigen::Quaterniond R = rest(stone, random);
    const double angle = start + 2 * kPi * i / count + random.uniform(-0.2, 0.2);
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    const double z = -lowest(at(stones_, stone), R);
    if (kind.arrangement == "stacked" && i > 0 && i < 3) {
      const Eigen::Vector3d above(random.uniform(-0.015, 0.015), random.uniform(-0.015, 0.015), 0.5);
      placed.push_back({stone, push(placed, stone, make_pose(above, R), -Eigen::Vector3d::UnitZ())});
    } else if (kind.arrangement == "stacked" && i == 0) {
      placed.push_back({stone, make_pose({0, 0, z}, R)});
    } else if (kind.arrangement == "touching" && i == 0) {
      placed.push_back({stone, make_pose(0.04 * out + z * Eigen::Vector3d::UnitZ(), R)});
    } else if (kind.arrangement == "touching") {
      const Pose far = make_pose(0.35 * out + z * Eigen::Vector3d::UnitZ(), R);
      placed.push_back({stone, push(placed, stone, far, -out)});
    } else {
      const double away = count == 1 ? 0.05 : kind.arrangement == "stacked" ? 0.17 : 0.14;
      placed.push_back({stone, make_pose(away * out + z * Eigen::Vector3d::UnitZ(), R)});
    }
  }
  return placed;
}

BenchScene SceneMaker::make(const SceneKind& kind, std::uint64_t seed, const CameraError& error) const {
  Random random = Random::stream(seed, "bench detection " + kind.arrangement);
  std::vector<PlacedStone> placed = arrange(kind, random);
  while (kind.arrangement == "apart" && placed.size() > 1) {  // large stones may meet: try again
    double nearest = 1;
    for (std::size_t i = 1; i < placed.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        nearest = std::min(nearest, gap(placed[i].stone, placed[i].T_W_O, placed[j].stone, placed[j].T_W_O));
    if (nearest > 0.015) break;
    placed = arrange(kind, random);
  }
  RayScene world;
  world.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  for (const auto& p : placed) world.add(at(stones_, p.stone).scan, p.T_W_O);
  world.commit();
  const SensorModel sensor = read_sensor(kind.sensor);
  const double tilt = random.uniform(kind.min_tilt, kind.max_tilt), azimuth = random.uniform(0, 2 * kPi);
  BenchScene scene;
  for (int v = 0; v < kind.views; ++v) {
    const double aside = v == 0 ? 0.0 : random.uniform(2.0, 2.0 * kPi - 2.0);
    const Pose T_W_C = camera_pose(tilt, azimuth + aside, random);
    const RenderedView view = render(world, sensor.camera, T_W_C);
    scene.views.push_back(
        {add_noise(view, T_W_C, sensor, random), v == 0 ? T_W_C : reported(T_W_C, error, random)});
    scene.shown.push_back(view.instance);
    for (int& instance : scene.shown.back()) instance = std::max(instance - 1, -1);  // 0 is the table
    if (kind.mirrored)
      mirror(scene.views.back().image);
    else if (v == 0)
      scene.truth = truth_of(placed, view, T_W_C, sensor.camera);
  }
  return scene;
}

BenchScene SceneMaker::views_around(StoneIndex stone, int views, std::uint64_t seed, const CameraError& error,
                                    double camera_tilt) const {
  Random random = Random::stream(seed, "bench views of " + at(stones_, stone).name);
  const Eigen::Quaterniond R = rest(stone, random);
  const Pose T_W_O = make_pose({0, 0, -lowest(at(stones_, stone), R)}, R);
  RayScene world;
  world.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  world.add(at(stones_, stone).scan, T_W_O);
  world.commit();
  const SensorModel sensor = read_sensor("sr300");
  const double start = random.uniform(0, 2 * kPi);
  BenchScene scene;
  for (int v = 0; v < views; ++v) {
    const Pose T_W_C = camera_pose(random.uniform(0.3, camera_tilt), start + 2 * kPi * v / views, random);
    const DepthImage image = add_noise(render(world, sensor.camera, T_W_C), T_W_C, sensor, random);
    scene.views.push_back({image, v == 0 ? T_W_C : reported(T_W_C, error, random)});
    if (v == 0) scene.truth.push_back({stone, T_W_C.inverse() * T_W_O, 1.0});
  }
  return scene;
}

std::vector<TrueStone> SceneMaker::truth_of(const std::vector<PlacedStone>& placed, const RenderedView& view,
                                            const Pose& T_W_C, const CameraIntrinsics& camera) const {
  std::vector<TrueStone> truth;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    RayScene alone;
    alone.add(at(stones_, placed[i].stone).scan, placed[i].T_W_O);
    alone.commit();
    const auto whole = pixels_of(render(alone, camera, T_W_C), 0);
    const auto seen = pixels_of(view, static_cast<int>(i) + 1);
    truth.push_back({placed[i].stone, T_W_C.inverse() * placed[i].T_W_O,
                     whole > 0 ? static_cast<double>(seen) / static_cast<double>(whole) : 0.0});
  }
  return truth;
}

}  // namespace stonestack::bench
