#include "stonestack/physics/equilibrium.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <limits>
#include <thread>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::physics {
namespace {

using Eigen::Vector3d;

/// Contacts at the corners of a level rectangle.
std::vector<Contact> patch(int below, int above, double half_x, double half_y, double z) {
  std::vector<Contact> out;
  for (const double x : {-half_x, half_x})
    for (const double y : {-half_y, half_y})
      out.push_back({below, above, {x, y, z}, Vector3d::UnitZ(), 0, 0});
  return out;
}

EquilibriumOptions with(double friction, int edges = 8) {
  EquilibriumOptions options;
  options.friction = friction;
  options.cone_edges = edges;
  return options;
}

TEST(Equilibrium, MarginOfACubeIsTipOrSlideWhicheverIsLess) {
  const std::vector<StaticBody> cube{{1.0, {0, 0, 0.03}}};
  const auto contacts = patch(kTable, 0, 0.03, 0.03, 0.0);
  EXPECT_NEAR(solve_equilibrium(cube, contacts, with(0.1)).margin, 0.1, 0.1 * 0.08) << "slides";
  EXPECT_NEAR(solve_equilibrium(cube, contacts, with(0.1, 64)).margin, 0.1, 1e-3) << "slides, round cone";
  EXPECT_NEAR(solve_equilibrium(cube, contacts, with(2.0)).margin, 1.0, 1e-4) << "tips: half width / height";
  const std::vector<StaticBody> tall{{1.0, {0, 0, 0.3}}};
  EXPECT_NEAR(solve_equilibrium(tall, contacts, with(0.5)).margin, 0.1, 1e-4) << "tips";
}

TEST(Equilibrium, MarginOfAStackIsThatOfItsWeakestJoint) {
  const std::vector<StaticBody> cubes{{1.0, {0, 0, 0.03}}, {1.0, {0, 0, 0.09}}};
  auto contacts = patch(kTable, 0, 0.03, 0.03, 0.0);
  const auto upper = patch(0, 1, 0.03, 0.03, 0.06);
  contacts.insert(contacts.end(), upper.begin(), upper.end());
  // Both together tip over the lower edge at half width / height of the common centre.
  EXPECT_NEAR(solve_equilibrium(cubes, contacts, with(2.0)).margin, 0.03 / 0.06, 1e-4);
}

TEST(Equilibrium, FallsWhenTheCentreIsOutside) {
  const std::vector<StaticBody> cube{{1.0, {0.031, 0, 0.03}}};
  const auto contacts = patch(kTable, 0, 0.03, 0.03, 0.0);
  const Equilibrium result = solve_equilibrium(cube, contacts, with(0.5));
  EXPECT_FALSE(result.stands);
  EXPECT_EQ(result.margin, 0.0);
  EXPECT_EQ(result.min_friction, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(
      solve_equilibrium(std::vector<StaticBody>{{1.0, {0.029, 0, 0.03}}}, contacts, with(0.5)).stands);
}

TEST(Equilibrium, MinFrictionOfATiltedBlockIsTheTangent) {
  for (const double tilt : {0.05, 0.2, 0.6}) {
    const Vector3d n(std::sin(tilt), 0, std::cos(tilt));
    const Vector3d along(std::cos(tilt), 0, -std::sin(tilt));
    const std::vector<StaticBody> block{{2.0, 0.01 * n}};
    std::vector<Contact> contacts;
    for (const double x : {-0.03, 0.03})
      for (const double y : {-0.03, 0.03})
        contacts.push_back({kTable, 0, x * along + y * Vector3d::UnitY(), n, 0, 0});
    EXPECT_NEAR(solve_equilibrium(block, contacts, with(0.1, 64)).min_friction, std::tan(tilt),
                0.01 * std::tan(tilt) + 1e-4);
    EXPECT_EQ(solve_equilibrium(block, contacts, with(1.02 * std::tan(tilt), 64)).stands, true);
    EXPECT_EQ(solve_equilibrium(block, contacts, with(0.98 * std::tan(tilt), 64)).stands, false);
  }
}

/// Two springers on the table and a keystone wedged between them, faces leaning by `lean`.
Equilibrium arch(double lean, double friction) {
  const Vector3d n_left(std::sin(lean), 0, std::cos(lean)), n_right(-std::sin(lean), 0, std::cos(lean));
  const std::vector<StaticBody> bodies{{2.0, {-0.1, 0, 0.05}}, {2.0, {0.1, 0, 0.05}}, {0.5, {0, 0, 0.1}}};
  std::vector<Contact> contacts;
  for (const double y : {-0.03, 0.03}) {
    for (const double x : {-0.15, -0.05}) contacts.push_back({kTable, 0, {x, y, 0}, Vector3d::UnitZ(), 0, 0});
    for (const double x : {0.05, 0.15}) contacts.push_back({kTable, 1, {x, y, 0}, Vector3d::UnitZ(), 0, 0});
    for (const double z : {0.09, 0.11}) {
      contacts.push_back({0, 2, {-0.03, y, z}, n_left, 0, 0});
      contacts.push_back({1, 2, {0.03, y, z}, n_right, 0, 0});
    }
  }
  return solve_equilibrium(bodies, contacts, with(friction, 32));
}

TEST(Equilibrium, ArchOfThreeBlocksIsStableByItsThrust) {
  // A steep joint holds the keystone by thrust; the springers must not slide: thrust <= friction * load.
  EXPECT_TRUE(arch(1.2, 0.5).stands);
  EXPECT_FALSE(arch(1.2, 0.05).stands);
  const Equilibrium at_limit = arch(1.2, 0.5);
  ASSERT_TRUE(std::isfinite(at_limit.min_friction));
  EXPECT_TRUE(arch(1.2, at_limit.min_friction * 1.01).stands);
  EXPECT_FALSE(arch(1.2, at_limit.min_friction * 0.98).stands);
  EXPECT_GE(at_limit.weakest_contact, 0);
}

TEST(Equilibrium, MoreFrictionNeverHurts) {
  for (std::uint64_t task = 0; task < 40; ++task) {
    Random random = Random::stream(5, task);
    std::vector<StaticBody> bodies{{random.uniform(0.5, 3), {0, 0, 0.05}}};
    std::vector<Contact> contacts;
    for (int i = 0; i < 5; ++i) {
      const Vector3d n = (Vector3d::UnitZ() + 0.3 * random.unit_vector()).normalized();
      contacts.push_back({kTable, 0, {random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 0}, n, 0, 0});
    }
    double before = 0.0;
    for (const double friction : {0.05, 0.1, 0.3, 0.6}) {
      const Equilibrium now = solve_equilibrium(bodies, contacts, with(friction));
      EXPECT_GE(now.margin, before - 5e-5) << "task " << task;
      EXPECT_EQ(now.stands, now.min_friction <= friction) << "task " << task;
      before = now.margin;
    }
  }
}

TEST(Equilibrium, ScaleOfMassesDoesNotMatterAndTwinsCountOnce) {
  std::vector<StaticBody> bodies{{1.0, {0, 0, 0.03}}, {0.4, {0.01, 0, 0.09}}};
  auto contacts = patch(kTable, 0, 0.03, 0.03, 0.0);
  for (const Contact& c : patch(0, 1, 0.02, 0.03, 0.06)) contacts.push_back(c);
  const double margin = solve_equilibrium(bodies, contacts, with(0.3)).margin;
  for (StaticBody& body : bodies) body.mass *= 1000.0;
  EXPECT_NEAR(solve_equilibrium(bodies, contacts, with(0.3)).margin, margin, 1e-6);
  auto doubled = contacts;
  doubled.insert(doubled.end(), contacts.begin(), contacts.end());
  EXPECT_NEAR(solve_equilibrium(bodies, doubled, with(0.3)).margin, margin, 1e-9);
}

volatile std::sig_atomic_t noted = 0;
void note(int) {
  noted = 1;
}

/// A solver that takes SIGINT over while it runs (Clp's `initialSolve` does) loses the program's handler when
/// two threads solve at once, and Ctrl-C no longer stops a run.
TEST(Equilibrium, LeavesTheHandlerOfCtrlCAlone) {
  struct sigaction own {
  }, before{};
  own.sa_handler = note;
  ASSERT_EQ(sigaction(SIGINT, &own, &before), 0);
  std::atomic<bool> done = false;
  std::thread solving([&] {
    for (int i = 0; i < 100; ++i) static_cast<void>(arch(1.2, 0.5));
    done = true;
  });
  long taken = 0;
  while (!done) {
    struct sigaction now {};
    sigaction(SIGINT, nullptr, &now);
    taken += now.sa_handler == note ? 0 : 1;
  }
  solving.join();
  EXPECT_EQ(taken, 0);
  ASSERT_EQ(sigaction(SIGINT, &before, nullptr), 0);
}

TEST(Equilibrium, RefusesWhatCannotBe) {
  const std::vector<StaticBody> none{{0.0, {0, 0, 0}}};
  const std::vector<StaticBody> one{{1.0, {0, 0, 0}}};
  const std::vector<Contact> stray{{0, 3, {0, 0, 0}, Vector3d::UnitZ(), 0, 0}};
  EXPECT_THROW(static_cast<void>(solve_equilibrium(none, {})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(solve_equilibrium(one, stray)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(solve_equilibrium(one, {}, with(std::nan("")))), InvalidArgument);
  EXPECT_FALSE(solve_equilibrium(one, {}).stands) << "a body in the air falls";
  const std::vector<Contact> nowhere{{kTable, 0, {std::nan(""), 0, 0}, Vector3d::UnitZ(), 0, 0}};
  EXPECT_THROW(static_cast<void>(solve_equilibrium(one, nowhere)), InvalidArgument);
  const std::vector<Contact> itself{{0, 0, {0, 0, 0}, Vector3d::UnitZ(), 0, 0}};
  EXPECT_FALSE(solve_equilibrium(one, itself).stands) << "no body carries itself";
}

}  // namespace
}  // namespace stonestack::physics
