#include "edge_mcl/audit/line_audit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "edge_mcl/audit/line_sights.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// The cupboard of the furnished rooms stands in the model. Whether it stands in the images is the
/// question.
const Eigen::Vector3d kLow(2.9, 4.2, 0), kHigh(3.8, 4.9, 1.9);

bool isOfCupboard(const AuditRow& row) {
  const auto inside = [](const Eigen::Vector3d& p) {
    return ((p - kLow).array() > -0.01).all() && ((kHigh - p).array() > -0.01).all();
  };
  return inside(row.start) && inside(row.end);
}

MeshModel roomsWithoutCupboard() {
  MeshModel mesh = test::furnishedRooms();
  leaveOutDoubted({{AuditRow::Part::kShape, kLow, kHigh, -1, 0, 0, 0, 0, "gone"}}, 0.5, &mesh);
  return mesh;
}

/// Audits the furnished rooms with images of `real`, from twelve places of the first room.
/// @param error of the poses that the audit is told, m
std::vector<AuditRow> audit(const MeshModel& real, bool with_depth,
                            const Eigen::Vector3d& error = Eigen::Vector3d::Zero()) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const LineSights sights(map);
  LineAudit audit(map, sights);
  const CameraModel camera = test::pinhole(320, 240, 220);
  for (int i = 0; i < 12; ++i) {
    const int column = i % 3, row = i / 3;
    const Pose pose = test::lookAlong({0.6 + 0.4 * column, 1.2 + 0.5 * row, 1.3 + 0.1 * (i % 2)},
                                      {1, 0.9 - 0.3 * row, -0.2});
    const auto image = map.prepare(camera, test::render(real, camera, pose, 1), {}, "test");
    const cv::Mat depth = with_depth ? test::renderDepth(real, camera, pose) : cv::Mat();
    Pose told = pose;
    told.translation() += error;
    audit.add(sights.find(*image, depth, told), told.translation());
  }
  return audit.judge();
}

double lengthOf(const std::vector<AuditRow>& rows, const std::string& verdict, bool of_cupboard) {
  double length = 0;
  for (const AuditRow& row : rows)
    if (row.part == AuditRow::Part::kLine && row.verdict == verdict &&
        isOfCupboard(row) == of_cupboard)
      length += (row.end - row.start).norm();
  return length;
}

/// All twelve edges of the box are gone with it, also those that no camera has seen: 4 x (0.9 + 0.7
/// + 1.9) m. No other line may be accused.
void expectGone(const std::vector<AuditRow>& rows) {
  const auto shapes = std::count_if(rows.begin(), rows.end(), [](const AuditRow& row) {
    return row.part == AuditRow::Part::kShape;
  });
  EXPECT_EQ(shapes, 1);
  EXPECT_NEAR(lengthOf(rows, "gone", true), 4 * (0.9 + 0.7 + 1.9), 0.05);
  EXPECT_EQ(lengthOf(rows, "gone", false), 0);
  // The walls of the first room are 3.95 m long. At least three of their edges are in view.
  EXPECT_GT(lengthOf(rows, "confirmed", false), 8);
}

TEST(LineAudit, ACupboardThatIsMissingInTheImagesIsFound) {
  expectGone(audit(roomsWithoutCupboard(), false));
}

TEST(LineAudit, AlsoWithDepth) { expectGone(audit(roomsWithoutCupboard(), true)); }

TEST(LineAudit, NothingIsAccusedInTheTrueModel) {
  for (const bool with_depth : {false, true}) {
    const std::vector<AuditRow> rows = audit(test::furnishedRooms(), with_depth);
    EXPECT_EQ(lengthOf(rows, "gone", true) + lengthOf(rows, "gone", false), 0);
    EXPECT_GT(lengthOf(rows, "confirmed", true), 3);
  }
}

TEST(LineAudit, WithoutImagesEverythingIsUnseen) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const LineSights sights(map);
  const LineAudit audit(map, sights);
  EXPECT_EQ(audit.seenPieces(), 0u);
  const std::vector<AuditRow> rows = audit.judge();
  EXPECT_FALSE(rows.empty());
  for (const AuditRow& row : rows) EXPECT_EQ(row.verdict, "unseen");
}

/// One place is not enough to judge: an image may be dark or blurred.
TEST(LineAudit, ManyImagesFromOnePlaceAreNoEvidence) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const LineSights sights(map);
  LineAudit audit(map, sights);
  const CameraModel camera = test::pinhole(320, 240, 220);
  const Pose pose = test::lookAlong({1, 2, 1.4}, {1, 0.7, -0.2});
  const cv::Mat black(camera.height, camera.width, CV_8U, cv::Scalar(0));
  const auto image = map.prepare(camera, black, {}, "test");
  for (int i = 0; i < 20; ++i) audit.add(sights.find(*image, {}, pose), pose.translation());
  const std::vector<AuditRow> rows = audit.judge();
  EXPECT_FALSE(rows.empty());
  for (const AuditRow& row : rows) EXPECT_EQ(row.verdict, "unseen");
}

/// With depth, something that stands before the model hides it. It does not contradict it.
TEST(LineAudit, WhatAnUnmappedThingHidesIsNotAccused) {
  MeshSoup soup;
  const MeshModel rooms = test::furnishedRooms();
  soup.vertices = rooms.vertices;
  soup.triangles = rooms.triangles;
  soup.triangle_material = rooms.triangle_material;
  test::addBox(&soup, {2.2f, 3.4f, 0}, {2.8f, 4.99f, 2.5f});  // hides the cupboard
  const std::vector<AuditRow> rows = audit(weldMesh(std::move(soup), 1e-6, "test"), true);
  EXPECT_EQ(lengthOf(rows, "gone", true) + lengthOf(rows, "gone", false), 0);
}

/// Poses that are 15 cm off show hardly a line where the model has it. The model is not to blame.
TEST(LineAudit, WrongPosesDoNotFitTheModel) {
  const MeshModel rooms = test::furnishedRooms();
  EXPECT_TRUE(fitsImages(audit(rooms, false)));
  EXPECT_FALSE(fitsImages(audit(rooms, false, {0.15, 0.15, 0.1})));
}

TEST(LineAudit, ABuildingThatWasNotSeenIsNotContradicted) { EXPECT_TRUE(fitsImages({})); }

}  // namespace
}  // namespace edge_mcl
