#pragma once

/// The floors of the library as the compiler sees them: each room is a namespace, and finds by their plain
/// names what it defines itself and what lower floors define. Names of rooms on the same floor or above are
/// not found. Outside the library write `stonestack::search::find_next_pose`, or include
/// `stonestack/stonestack.hpp` for the names that most programs need.
namespace stonestack {
namespace core {}     // namespace core
namespace geometry {  // floor 1
using namespace core;
}
namespace stone {  // floor 2
using namespace geometry;
}
namespace kinematics {
using namespace geometry;
}
namespace protocol {
using namespace geometry;
}
namespace physics {  // floor 3
using namespace stone;
using namespace kinematics;
}  // namespace physics
namespace detection {
using namespace stone;
using namespace kinematics;
}  // namespace detection
namespace motion {
using namespace stone;
using namespace kinematics;
}  // namespace motion
namespace hardware {
using namespace stone;
using namespace kinematics;
using namespace protocol;
}  // namespace hardware
namespace search {  // floor 4
using namespace physics;
using namespace detection;
using namespace motion;
using namespace hardware;
}  // namespace search
namespace modelling {
using namespace physics;
using namespace detection;
}  // namespace modelling
namespace stacking {  // floor 5
using namespace search;
using namespace modelling;
}  // namespace stacking
namespace simulation {
using namespace search;
}
namespace urscript {
using namespace search;
}
namespace emulators {
using namespace simulation;
using namespace urscript;
}  // namespace emulators
namespace experiment {  // floor 6
using namespace stacking;
using namespace emulators;
}  // namespace experiment
namespace report {  // floor 7
using namespace experiment;
}
}  // namespace stonestack
