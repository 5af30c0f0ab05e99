#include "edge_mcl/localization/tracking/surface_agreement.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {
namespace {

PoseGaussian known(double metres, double degrees = 0.5) {
  PoseGaussian pose;
  pose.covariance.diagonal() << Eigen::Vector3d::Constant(metres * metres),
      Eigen::Vector3d::Constant(degrees * degrees * kDegree * kDegree);
  return pose;
}

ForeignPoints seen(size_t compared, size_t in_front, double agreement) {
  ForeignPoints found;
  found.compared = compared;
  found.points.resize(in_front);
  found.agreement = agreement;
  return found;
}

TEST(SurfaceAgreement, IsTheMeanOverThePixelsOfAllSensors) {
  SurfaceAgreement surface;
  surface.begin(0, known(0.02));
  EXPECT_FALSE(surface.value().has_value());
  surface.add(seen(9000, 1000, 0.9));  // 8000 pixels, 7200 of them on the model
  surface.add(seen(4000, 0, 0.6));     // 4000 and 2400
  ASSERT_TRUE(surface.value().has_value());
  EXPECT_NEAR(*surface.value(), 0.8, 1e-12);
}

/// A covered camera, a hand before it, and a pose that may be anywhere say nothing.
TEST(SurfaceAgreement, LittleDepthSaysNothing) {
  SurfaceAgreement surface;
  for (const ForeignPoints& found :
       {seen(0, 0, 0), seen(40, 0, 1), seen(19000, 19000, 0), seen(19000, 18000, 1)}) {
    surface.forget();
    surface.begin(0, known(0.02));
    surface.add(found);
    EXPECT_FALSE(surface.value().has_value()) << found.compared;
  }
}

TEST(SurfaceAgreement, APoseThatIsKnownBadlyAgreesWithAnything) {
  SurfaceAgreement surface;
  for (const PoseGaussian& pose : {known(0.2), known(0.02, 5)}) {
    surface.begin(0, pose);
    surface.add(seen(9000, 0, 1));
    EXPECT_FALSE(surface.value().has_value());
  }
}

/// Colour at 30 Hz, depth at 5 Hz.
TEST(SurfaceAgreement, HoldsUntilASlowDepthCameraSendsTheNextImage) {
  SurfaceAgreement surface;
  surface.begin(0, known(0.02));
  surface.add(seen(9000, 0, 0.9));
  for (int i = 1; i <= 6; ++i) {
    surface.begin(i / 30.0, known(0.02));
    ASSERT_TRUE(surface.value().has_value()) << i;
    EXPECT_NEAR(*surface.value(), 0.9, 1e-12);
  }
  surface.begin(0.5, known(0.02));
  EXPECT_FALSE(surface.value().has_value());
  surface.begin(0.55, known(0.02));
  surface.add(seen(0, 0, 0));  // the newest image has no depth in range
  surface.begin(0.6, known(0.02));
  EXPECT_FALSE(surface.value().has_value());
}

TEST(SurfaceAgreement, AnotherPoseBeginsAgain) {
  SurfaceAgreement surface;
  surface.begin(0, known(0.02));
  surface.add(seen(9000, 0, 0.9));
  surface.forget();
  surface.begin(0.03, known(0.02));
  EXPECT_FALSE(surface.value().has_value());
}

}  // namespace
}  // namespace edge_mcl
