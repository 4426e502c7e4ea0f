#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::hardware {

/// Time limit of a connection to a Modbus device or a camera server, s. Design choice.
inline constexpr double kConnectTimeout = 2.0;

// UR arm
/// Allowed share of the trajectory's duration at the speed that the slider leaves. Design choice.
inline constexpr double kTimeFactor = 1.5;
/// Period of the heartbeat, s. Design choice.
inline constexpr double kHeartbeatPeriod = 0.02;
/// Joint speed below which the arm stands still, rad/s. Design choice.
inline constexpr double kStandstillSpeed = 0.01;

// RTDE
/// Time of the controller's clock after which it has booted, s. UR client library.
inline constexpr double kBootedTime = 40.0;
/// Duration of data that also show that it has booted, s. UR client library: two seconds.
inline constexpr double kBootedData = 1.0;

// URScript
/// Look-ahead time of servoj, s: 0.1 cuts corners by 3e-3 rad, this by less than 1e-3.
inline constexpr double kLookahead = 0.04;
/// Gain of servoj. UR script manual: 100 to 2000.
inline constexpr double kGain = 300;
/// Lag beyond the normal tracking delay at which the path waits for a slower arm, rad. Design choice.
inline constexpr double kHoldLag = 0.02;
/// Distance to the end of the path that counts as arrived, rad. Design choice.
inline constexpr double kArrived = 0.002;
/// Readings whose mean is the force at the start. Design choice.
inline constexpr int kForceSamples = 10;
/// Force along the direction while complying, N. Design choice.
inline constexpr double kComplyForce = 10.0;
/// Speed while complying, m/s. Design choice.
inline constexpr double kComplySpeed = 0.01;
/// Distance between the first knot and the arm, rad. stonestack/hardware/devices.hpp.
inline constexpr double kStartTolerance = 0.01;
/// Allowed share of the joint speed limits. Design choice.
inline constexpr double kSpeedMargin = 1.01;

// What a fence counts on at the flange: inside what plans count on (motion::make_robotiq_3f)
/// Half the width of palm, sensor and coupling, m. Robotiq's meshes.
inline constexpr double kMountedHalfWidth = 0.060;
/// Distance from the tool's tip back to the palm, m. Robotiq's meshes.
inline constexpr double kMountedFront = 0.112;

// Three-finger gripper
/// Spacing of the pads of fingers B and C at kWideCount, m. Robotiq's model of the gripper.
inline constexpr double kWideSpacing = 0.073;
/// Scissor count of basic mode. Robotiq manual: 0x89.
inline constexpr double kWideCount = 137.0;
/// Spacing of the pads of fingers B and C side by side, m. Design choice.
inline constexpr double kNarrowSpacing = 0.042;
/// Counts short of the request that an object needs at least. Design choice.
inline constexpr double kObjectMargin = 6.0;
/// Time limit of a change of mode, s. Robotiq manual: fault after 20 s.
inline constexpr double kModeTimeout = 25.0;
/// Bit rate of the serial line. Robotiq manual.
inline constexpr int kGripperBaud = 115200;
/// Port of the text socket of Robotiq's URCap. ur_rtde, RobotiqGripper.
inline constexpr int kUrCapPort = 63352;

// Force sensor
/// Bit rate of the serial line. Robotiq manual.
inline constexpr int kSensorBaud = 19200;
/// Time without a reading until the stream is started again, s. Design choice.
inline constexpr double kSilence = 0.5;
/// Readings whose mean is the zero. Design choice.
inline constexpr int kZeroSamples = 20;
/// Time limit of zeroing, s. Design choice.
inline constexpr double kZeroTimeout = 2.0;
/// Spread of the readings while zeroing, N; more is not at rest. Design choice.
inline constexpr double kZeroSpread = 5.0;

/// Height of the sensor that a gripper stands on, m, where the arm has none of its own. FT150, Robotiq's
/// meshes.
inline constexpr double kSensorHeight = 0.041;
/// Rate at which the arm's own sensor is read, Hz: that of Robotiq's, so that a number of readings takes the
/// same time. A divisor of the control rate.
inline constexpr double kOwnSensorRate = 100.0;
/// Range of the arm's own sensor about an axis, Nm. UR's data sheets of the e-Series.
inline constexpr double kOwnSensorTorque = 10.0;

// Cameras
/// Buffers of a V4L2 driver. Design choice.
inline constexpr int kBuffers = 4;
/// Share of the pixels with a depth at least. Design choice.
inline constexpr double kMinValid = 0.02;
/// Median depth of a frame at least, m: nearer means a wrong scale. Design choice.
inline constexpr double kNearestMedian = 0.05;
/// Median depth of a frame at most, m. Design choice.
inline constexpr double kFarthestMedian = 10.0;

}  // namespace stonestack::hardware
