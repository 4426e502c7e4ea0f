#include "motion/grasp_cache.hpp"

#include <bit>
#include "core/recently_used.hpp"
#include "motion/grasp.hpp"
#include "motion/grasp/finger_strips.hpp"

namespace stonestack::motion {
namespace {

/// Mixes numbers into one 64 bit key (splitmix64's finaliser).
class Key {
 public:
  void add(std::uint64_t word) {
    key_ ^= word + 0x9e3779b97f4a7c15u;
    key_ = (key_ ^ (key_ >> 30)) * 0xbf58476d1ce4e5b9u;
    key_ = (key_ ^ (key_ >> 27)) * 0x94d049bb133111ebu;
    key_ ^= key_ >> 31;
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  [[nodiscard]] std::uint64_t value() const { return key_; }

 private:
  std::uint64_t key_ = 0;
};

std::uint64_t key_of(const Stone& stone, const GripperModel& gripper, GraspOptions options) {
  Key key;
  for (const Eigen::Vector3d& v : stone.scan.vertices) key.add(v);
  key.add(static_cast<std::uint64_t>(stone.scan.faces.size()));
  key.add(stone.mass.mass);
  key.add(stone.mass.p_O_M);
  for (const double v :
       {gripper.max_opening, gripper.min_object, gripper.finger_width, gripper.finger_spacing,
        gripper.narrow_spacing, gripper.pad_length, gripper.force, gripper.friction})
    key.add(v);
  key.add(palm_front(gripper));  // all that sampling asks of the boxes: a camera beside the palm changes none
  key.add(static_cast<std::uint64_t>(gripper.linkage));
  key.add(static_cast<std::uint64_t>(gripper.against));
  for (const TipAdvance& tip : gripper.tips) {
    key.add(tip.opening);
    key.add(tip.advance);
  }
  key.add(options.n_O_towards);
  for (const Field& field : fields(options)) {
    if (const auto* number = std::get_if<double*>(&field.value)) key.add(**number);
    if (const auto* count = std::get_if<int*>(&field.value)) key.add(static_cast<std::uint64_t>(**count));
  }
  return key.value();
}

}  // namespace

std::shared_ptr<const GraspSet> cached_grasps(const Stone& stone, const GripperModel& gripper,
                                              const GraspOptions& options) {
  static RecentlyUsed<GraspSet> made(kMaxGraspSets);
  const std::uint64_t key = key_of(stone, gripper, options);
  if (auto known = made.find(key)) return known;
  return made.keep(key, std::make_shared<const GraspSet>(grasp_candidates(stone, gripper, options)));
}

}  // namespace stonestack::motion
