#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::hardware {

// UR arm
inline constexpr double kTimeFactor =
    1.5;  // times the trajectory's duration, at the speed that the slider leaves; design choice
inline constexpr double kHeartbeatPeriod = 0.02;  // s; design choice
inline constexpr double kStandstillSpeed = 0.01;  // rad/s below which the arm stands; design choice

// RTDE
inline constexpr double kBootedTime =
    40.0;  // s of the controller's clock after which it has booted; UR client library
inline constexpr double kBootedData = 1.0;  // s of data that also show it; UR client library: two seconds

// URScript
inline constexpr double kLookahead = 0.04;  // s, servoj; 0.1 cuts corners by 3e-3 rad, this by less than 1e-3
inline constexpr double kGain = 300;        // servoj; UR script manual: 100 to 2000
inline constexpr double kHoldLag =
    0.02;  // rad beyond the normal tracking delay; the path waits for a slower arm; design choice
inline constexpr double kArrived = 0.002;        // rad at the end of the path; design choice
inline constexpr int kForceSamples = 10;         // whose mean is the force at the start; design choice
inline constexpr double kComplyForce = 10.0;     // N along the direction while complying; design choice
inline constexpr double kComplySpeed = 0.01;     // m/s; design choice
inline constexpr double kStartTolerance = 0.01;  // rad between the first knot and the arm; hardware/arm.hpp
inline constexpr double kSpeedMargin = 1.01;     // times the joint speed limit; design choice

// Three-finger gripper
inline constexpr double kWideSpacing =
    0.073;  // m between the pads of B and C at kWideCount; Robotiq's model of the hand
inline constexpr double kWideCount = 137.0;      // of the scissor; Robotiq manual: 0x89 in basic mode
inline constexpr double kNarrowSpacing = 0.042;  // m at narrow_count: fingers side by side; design choice
inline constexpr double kObjectMargin =
    6.0;  // counts short of the request that an object needs at least; design choice
inline constexpr double kModeTimeout = 25.0;  // s; Robotiq manual: fault after 20 s

// Force sensor
inline constexpr int kSensorBaud = 19200;  // Robotiq manual
inline constexpr double kSilence =
    0.5;  // s without a reading until the stream is started anew; design choice
inline constexpr int kZeroSamples = 20;      // readings whose mean is the zero; design choice
inline constexpr double kZeroTimeout = 2.0;  // s; design choice
inline constexpr double kZeroSpread =
    5.0;  // N between readings while zeroing; more is not at rest; design choice

// Modbus on a serial line
inline constexpr int kGripperBaud = 115200;  // Robotiq manual

// Cameras
inline constexpr int kBuffers = 4;         // of the driver; design choice
inline constexpr double kMinValid = 0.02;  // share of the pixels with a depth; design choice
inline constexpr double kNearest = 0.05;  // m, of the median depth: nearer means a wrong scale; design choice
inline constexpr double kFarthest = 10.0;  // m, the same

}  // namespace stonestack::hardware
