// Tests which poses an autopilot gets.
#include "edge_mcl/nodes/mavros/vision_gate.h"

#include <gtest/gtest.h>

#include <limits>

namespace edge_mcl {
namespace {

Pose at(double x, double yaw = 0) {
  Pose pose = Pose::Identity();
  pose.translation().x() = x;
  pose.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

/// Sends sure images at 10 Hz. @param from, to numbers of the images @return times at which the
/// gate was open
int fly(VisionGate* gate, int from, int to, double speed = 0, double probability = 0.95,
        double offset = 0) {
  int open = 0;
  for (int i = from; i < to; ++i) {
    gate->update(0.1 * i, true, probability, at(offset + 0.1 * i * speed));
    open += gate->isOpen(0.1 * i) ? 1 : 0;
  }
  return open;
}

/// 0.3 s are four images, so the first three are withheld.
TEST(VisionGate, OpensAfterAWhile) {
  VisionGate gate{VisionGateParameters()};
  EXPECT_FALSE(gate.isOpen(0));
  EXPECT_EQ(fly(&gate, 0, 20), 17);
  EXPECT_EQ(gate.resets(), 1);
  EXPECT_TRUE(gate.isOpen(1.9 + 0.2));   // a pose by odometry, between images
  EXPECT_FALSE(gate.isOpen(1.9 + 0.3));  // no image for too long
}

TEST(VisionGate, ClosesAtOnceInDoubt) {
  VisionGate gate{VisionGateParameters()};
  fly(&gate, 0, 20);
  gate.update(2.0, true, 0.6, at(0));
  EXPECT_FALSE(gate.isOpen(2.0));
  EXPECT_EQ(fly(&gate, 21, 31), 7);
  EXPECT_EQ(gate.resets(), 2);
  gate.update(3.1, false, 0.99, at(0));  // converging, degraded or lost
  EXPECT_FALSE(gate.isOpen(3.1));
  EXPECT_EQ(fly(&gate, 32, 42, 0, std::numeric_limits<double>::quiet_NaN()), 0);
}

/// A pose two metres away is a relocalization, although the state stays `tracking`.
TEST(VisionGate, AJumpIsAReset) {
  VisionGate gate{VisionGateParameters()};
  fly(&gate, 0, 20);
  EXPECT_EQ(fly(&gate, 20, 30, 0, 0.95, 2), 7);
  EXPECT_EQ(gate.resets(), 2);
  VisionGate turned{VisionGateParameters()};
  fly(&turned, 0, 20);
  turned.update(2.0, true, 0.95, at(0, 0.3));
  EXPECT_FALSE(turned.isOpen(2.0));
}

/// 8 m/s are 0.8 m from image to image.
TEST(VisionGate, AFastFlightIsNoJump) {
  VisionGate gate{VisionGateParameters()};
  // It accelerates by 2 m/s each 0.1 s at most, as from rest to full speed in 0.4 s.
  double x = 0;
  int open = 0;
  for (int i = 0; i < 40; ++i) {
    x += 0.1 * std::min(8.0, 2.0 * i);
    gate.update(0.1 * i, true, 0.95, at(x));
    open += gate.isOpen(0.1 * i) ? 1 : 0;
  }
  EXPECT_EQ(open, 37);
  EXPECT_EQ(gate.resets(), 1);
}

TEST(VisionGate, AClockThatIsSetBackBeginsAgain) {
  VisionGate gate{VisionGateParameters()};
  fly(&gate, 100, 120);
  EXPECT_EQ(fly(&gate, 0, 10), 7);
  EXPECT_EQ(gate.resets(), 2);
}

}  // namespace
}  // namespace edge_mcl
