#pragma once
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "detection/hypotheses/candidates.hpp"

namespace stonestack::detection {

/// State of the part of a scene that a verdict rests on. A search takes points and pixels out of its scene
/// and adds none, so counts are enough to see that a part is as it was.
struct SceneState {
  std::size_t taken = 0;  ///< stones taken out of the scene by then
  long explained = 0;     ///< explained pixels about the pose, in all views
};

/// The state about a pose of a model.
[[nodiscard]] SceneState state_about(const DetectionModel& model, const Pose& T_C_O,
                                     const DetectionScene& scene);

/// A verdict on a pose, with the pose that a registration ended at and the state of the scene about it.
template <class T>
struct Judged {
  Pose T_C_O_last = Pose::Identity();
  SceneState state;
  T verdict{};
};

/// Verdicts on poses of one model, by the pose that each began with. Memoization of a pure function: what is
/// looked up is what would be computed again.
template <class T>
class PoseMemory {
 public:
  /// The verdict on a pose, if what it rests on is still the same.
  [[nodiscard]] const Judged<T>* find(const DetectionModel& model, const Pose& T_C_O,
                                      const DetectionScene& scene) const;
  /// Keeps the verdict on the pose T_C_O, which a registration moved to T_C_O_last.
  void keep(const DetectionModel& model, const Pose& T_C_O, const Pose& T_C_O_last,
            const DetectionScene& scene, T verdict);

 private:
  std::unordered_map<std::uint64_t, Judged<T>> judged_;
};

/// 64 bits of a pose: equal poses have equal ones, and others hardly ever.
[[nodiscard]] std::uint64_t fingerprint(const Pose& pose);

/// 64 bits of some points of a surface that one view saw.
[[nodiscard]] std::uint64_t fingerprint(const SurfacePoints& seen, std::span<const int> points, int view);

/// True if nothing was taken out of the scene since `state` that a verdict on a pose rests on, which a
/// registration moved from T_C_O to T_C_O_last.
[[nodiscard]] bool still_holds(const SceneState& state, const DetectionModel& model, const Pose& T_C_O,
                               const Pose& T_C_O_last, const DetectionScene& scene);

template <class T>
const Judged<T>* PoseMemory<T>::find(const DetectionModel& model, const Pose& T_C_O,
                                     const DetectionScene& scene) const {
  const auto found = judged_.find(fingerprint(T_C_O));
  if (found == judged_.end()) return nullptr;
  const Judged<T>& known = found->second;
  return still_holds(known.state, model, T_C_O, known.T_C_O_last, scene) ? &known : nullptr;
}

template <class T>
void PoseMemory<T>::keep(const DetectionModel& model, const Pose& T_C_O, const Pose& T_C_O_last,
                         const DetectionScene& scene, T verdict) {
  judged_[fingerprint(T_C_O)] = {T_C_O_last, state_about(model, T_C_O_last, scene), std::move(verdict)};
}

/// Findings of a search about one model in its earlier turns.
struct ModelMemory {
  /// From descriptors: of what is left of a scene they are as they were, but near what was taken.
  std::optional<std::vector<Hypothesis>> grouped;
  std::unordered_map<std::uint64_t, std::vector<Hypothesis>> swept;  ///< by cluster, of the quick sweep ...
  std::unordered_map<std::uint64_t, std::vector<Hypothesis>> swept_thoroughly;  ///< ... and of the other
  PoseMemory<double> coarse;                  ///< score of a coarse registration
  PoseMemory<std::optional<Candidate>> fine;  ///< verdict after a fine one; empty below what is kept
};

}  // namespace stonestack::detection
