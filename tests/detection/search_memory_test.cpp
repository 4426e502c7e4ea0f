#include "detection/hypotheses/search_memory.hpp"

#include <gtest/gtest.h>

#include "core/constants.hpp"
#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

/// Three stones in a heap, and hypotheses about the first: a third near its pose, the others anywhere.
class SearchMemory : public test::StonesOnce<3> {
 protected:
  struct Heap {
    DetectionScene scene;
    std::vector<KnownStone> truth;
    std::vector<Hypothesis> hypotheses;
  };

  static Heap drawn_heap(int number) {
    Random random = Random::stream(static_cast<std::uint64_t>(number), "search memory");
    const Pose T_W_C = test::make_camera_pose(random.uniform(0.2, 0.9), random.uniform(0, 6.28));
    Heap heap;
    std::vector<test::StandingStone> standing;
    for (int k = 0; k < 3; ++k) {
      const Stone& stone = stones()[static_cast<std::size_t>(k)];
      const Pose T_W_O = test::on_table(stone, random.rotation(), 0.07 * k + random.uniform(-0.02, 0.02),
                                        random.uniform(-0.07, 0.07));
      standing.push_back({&stone, T_W_O});
      heap.truth.push_back({StoneIndex(k), T_W_C.inverse() * T_W_O});
    }
    heap.scene = preprocess(
        test::with_noise(test::look_at(standing, T_W_C), 0.0008, static_cast<std::uint64_t>(number)), {},
        true, {});
    for (int k = 0; k < 30; ++k) {
      const Pose& T_C_O = heap.truth[static_cast<std::size_t>(k % 3)].T_C_O;
      const Eigen::Quaterniond turn =
          k % 3 == 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(random.uniform(0, 0.4), random.unit_vector()))
                     : random.rotation();
      heap.hypotheses.push_back(
          {make_pose(0.01 * random.unit_vector()) * T_C_O * make_pose({0, 0, 0}, turn), 1.0});
    }
    return heap;
  }
};

TEST_F(SearchMemory, GivesWhatIsJudgedWithoutIt) {
  const auto& data = models()->data();
  const DetectionModel& model = data.models[0];
  std::size_t judged = 0;
  for (int number = 0; number < 6; ++number) {
    Heap heap = drawn_heap(number);
    ModelMemory memory;
    for (int turn = 0; turn < 2; ++turn) {
      if (turn == 1)
        heap.scene = without_stones(std::move(heap.scene), data, std::vector<KnownStone>{heap.truth[1]});
      const auto with =
          judge_hypotheses(model, 0_stone, heap.hypotheses, heap.scene, {}, kKeptPoses, &memory);
      const auto without = judge_hypotheses(model, 0_stone, heap.hypotheses, heap.scene, {});
      ASSERT_EQ(with.size(), without.size()) << "heap " << number << ", turn " << turn;
      for (std::size_t k = 0; k < with.size(); ++k) {
        EXPECT_EQ(with[k].detection.T_C_O.matrix(), without[k].detection.T_C_O.matrix());
        EXPECT_EQ(with[k].detection.score, without[k].detection.score);
        EXPECT_EQ(with[k].pixels.size(), without[k].pixels.size());
      }
      judged += with.size();
    }
  }
  EXPECT_GT(judged, 6U) << "hardly anything was compared";
}

TEST_F(SearchMemory, WatchesThePlaceWhereARefutedPoseEndedUp) {
  const DetectionModel& model = models()->data().models[0];
  int refuted = 0;
  for (int number = 0; number < 6; ++number) {
    const Heap heap = drawn_heap(number);
    ModelMemory memory;
    (void)judge_hypotheses(model, 0_stone, heap.hypotheses, heap.scene, {}, kKeptPoses, &memory);
    for (const Hypothesis& h : heap.hypotheses) {
      const auto* coarse = memory.coarse.find(model, h.T_C_O, heap.scene);
      ASSERT_NE(coarse, nullptr);
      const auto* fine = memory.fine.find(model, coarse->T_C_O_last, heap.scene);
      if (fine == nullptr || fine->verdict) continue;
      const auto again = judge_pose(model, 0_stone, coarse->T_C_O_last, heap.scene, 0.1);
      if (!again) continue;
      EXPECT_EQ(fine->T_C_O_last.matrix(), again->detection.T_C_O.matrix());
      ++refuted;
    }
  }
  EXPECT_GT(refuted, 3) << "hardly anything was compared";
}

}  // namespace
}  // namespace stonestack::detection
