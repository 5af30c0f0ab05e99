#include "edge_mcl/core/recordings/trajectory_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

/// The reference has ten times the rate of the estimate. Nine of the ten estimated poses are right:
/// 9 % of all reference poses, 90 % of the matched ones.
TEST(TrajectoryEvaluation, ADenseReferenceCostsNoSuccess) {
  Trajectory estimate, reference;
  for (int k = 0; k < 100; ++k) {
    reference.push_back({0.01 * k, "", Pose::Identity()});
    if (k % 10 == 0) estimate.push_back(reference.back());
  }
  estimate.back().pose.translation().x() = 1;
  const TrajectoryErrors errors = evaluateTrajectory(estimate, reference);
  EXPECT_EQ(errors.matched, 10u);
  EXPECT_NEAR(errors.success_share, 0.09, 1e-12);
  EXPECT_NEAR(errors.success_share_of_matched, 0.9, 1e-12);
}

/// The numbers 1 to 4, in any order: their squares add up to 30, and percentile q lies at the
/// position 3 q between them.
TEST(Summarize, HasTheStatisticsOfAList) {
  for (const std::vector<double>& values :
       {std::vector<double>{1, 2, 3, 4}, std::vector<double>{3, 1, 4, 2}}) {
    const ErrorSummary s = summarize(values);
    EXPECT_DOUBLE_EQ(s.mean, 2.5);
    EXPECT_DOUBLE_EQ(s.median, 2.5);
    EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(30 / 4.0));
    EXPECT_DOUBLE_EQ(s.p90, 3.7);
    EXPECT_DOUBLE_EQ(s.max, 4);
  }
}

TEST(Summarize, OfOneValueIsThisValueAndOfNoneIsZero) {
  const ErrorSummary one = summarize({7});
  for (const double v : {one.mean, one.median, one.rmse, one.p90, one.max}) EXPECT_EQ(v, 7);
  const ErrorSummary none = summarize({});
  for (const double v : {none.mean, none.median, none.rmse, none.p90, none.max}) EXPECT_EQ(v, 0);
}

StampedPose at(double time, double x, double yaw_deg = 0) {
  StampedPose p;
  p.time = time;
  p.pose.translation().x() = x;
  p.pose.linear() = rotationFromAngles(0, 0, yaw_deg * M_PI / 180);
  return p;
}

/// The estimate is 0.2 m aside and turned by 2 degrees everywhere. The trajectories are not
/// aligned, so all of this is error. The motion between neighbours is right except for the turn of
/// its direction by 2 degrees: a step of 1 m has an error of 2 sin(1 degree) m.
TEST(TrajectoryEvaluation, AConstantErrorIsOfPositionAndNotOfMotion) {
  Trajectory estimate, reference;
  for (int k = 0; k < 5; ++k) {
    reference.push_back(at(k, k));
    estimate.push_back(at(k, k, 2));
    estimate.back().pose.translation().y() = 0.2;
  }
  const TrajectoryErrors errors = evaluateTrajectory(estimate, reference);
  EXPECT_EQ(errors.reference_poses, 5u);
  ASSERT_EQ(errors.matched, 5u);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(errors.time[i], static_cast<double>(i));
    EXPECT_NEAR(errors.position[i], 0.2, 1e-12);
    EXPECT_NEAR(errors.rotation[i], 2, 1e-9);
  }
  EXPECT_NEAR(errors.position_summary.rmse, 0.2, 1e-12);
  EXPECT_NEAR(errors.rotation_summary.median, 2, 1e-9);
  EXPECT_NEAR(errors.relative_position.max, 2 * std::sin(M_PI / 180), 1e-9);
  EXPECT_NEAR(errors.relative_rotation.max, 0, 1e-6);
}

/// The error grows by 0.1 m and by 0.5 degrees from one second to the next.
TEST(TrajectoryEvaluation, DriftIsAnErrorOfMotion) {
  Trajectory estimate, reference;
  for (int k = 0; k < 5; ++k) {
    reference.push_back(at(k, 0));
    estimate.push_back(at(k, 0.1 * k, 0.5 * k));
  }
  const TrajectoryErrors errors = evaluateTrajectory(estimate, reference);
  EXPECT_NEAR(errors.relative_position.mean, 0.1, 1e-9);
  EXPECT_NEAR(errors.relative_position.max, 0.1, 1e-9);
  EXPECT_NEAR(errors.relative_rotation.mean, 0.5, 1e-6);
  EXPECT_NEAR(errors.position_summary.max, 0.4, 1e-12);
}

/// A pose is a success when both its errors are within the limits. Here the position is right three
/// times, the rotation is right three times, and both are right twice.
TEST(TrajectoryEvaluation, SuccessNeedsPositionAndRotation) {
  const Trajectory reference = {at(0, 0), at(1, 0), at(2, 0), at(3, 0), at(9, 0)};
  const Trajectory estimate = {at(0, 0.04), at(1, 0.06, 1), at(2, 0.04, 4), at(3, 0.04, 2)};
  const TrajectoryErrors errors = evaluateTrajectory(estimate, reference, 0.005, 0.05, 3);
  EXPECT_NEAR(errors.success_share, 2 / 5.0, 1e-12);
  EXPECT_NEAR(errors.success_share_of_matched, 2 / 4.0, 1e-12);
  const TrajectoryErrors generous = evaluateTrajectory(estimate, reference, 0.005, 0.1, 5);
  EXPECT_NEAR(generous.success_share_of_matched, 1, 1e-12);
}

/// The truth tries every estimate. Times are random, and the x coordinate of an estimate is its
/// time. So the error tells which estimate was taken.
TEST(TrajectoryEvaluation, PairsAreNearestInTime) {
  RandomSource random(2);
  for (const double window : {0.0, 0.005, 0.03}) {
    Trajectory estimate, reference;
    for (int k = 0; k < 300; ++k) {
      estimate.push_back(at(10 * random.uniform(), 0));
      estimate.back().pose.translation().x() = estimate.back().time;
      reference.push_back(
          at(0.05 * k - 1, 0));  // also before the first and after the last estimate
    }
    std::sort(estimate.begin(), estimate.end(),
              [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
    std::vector<double> times, expected;
    for (const StampedPose& r : reference) {
      double nearest = INFINITY;
      for (const StampedPose& e : estimate)
        if (std::abs(e.time - r.time) < std::abs(nearest - r.time)) nearest = e.time;
      if (std::abs(nearest - r.time) > window) continue;
      times.push_back(r.time);
      expected.push_back(nearest);
    }
    const TrajectoryErrors errors = evaluateTrajectory(estimate, reference, window);
    EXPECT_EQ(errors.time, times);
    EXPECT_EQ(errors.position, expected);
  }
}

/// 0.3 + 0.005 is not exact in binary. A difference of the window must count all the same.
TEST(TrajectoryEvaluation, ADifferenceOfExactlyTheWindowMatches) {
  for (const double time : {0.0, 0.3, 77.7}) {
    EXPECT_EQ(evaluateTrajectory({at(time, 0)}, {at(time + 0.005, 0)}).matched, 1u);
    EXPECT_EQ(evaluateTrajectory({at(time + 0.005, 0)}, {at(time, 0)}).matched, 1u);
    EXPECT_EQ(evaluateTrajectory({at(time, 0)}, {at(time + 0.0051, 0)}).matched, 0u);
  }
}

TEST(TrajectoryEvaluation, WithoutPosesThereAreNoErrors) {
  const Trajectory some = {at(0, 0), at(1, 0)};
  const TrajectoryErrors no_estimate = evaluateTrajectory({}, some);
  EXPECT_EQ(no_estimate.reference_poses, 2u);
  EXPECT_EQ(no_estimate.matched, 0u);
  EXPECT_EQ(no_estimate.success_share, 0);
  EXPECT_EQ(no_estimate.success_share_of_matched, 0);
  EXPECT_EQ(no_estimate.position_summary.max, 0);
  const TrajectoryErrors no_reference = evaluateTrajectory(some, {});
  EXPECT_EQ(no_reference.reference_poses, 0u);
  EXPECT_EQ(no_reference.success_share, 0);
  EXPECT_EQ(evaluateTrajectory(some, {some[0]}).relative_position.max, 0);
}

}  // namespace
}  // namespace edge_mcl
