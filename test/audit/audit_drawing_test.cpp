#include "edge_mcl/audit/audit_drawing.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "support/painted.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

class AuditDrawing : public test::WithFolder {};

std::vector<AuditRow> rows() {
  AuditRow confirmed, gone, shape;
  confirmed.start = {0, 0, 0};
  confirmed.end = {4, 0, 0};
  confirmed.verdict = "confirmed";
  gone.start = {0, 0, 0};
  gone.end = {0, 3, 0};
  gone.verdict = "gone";
  shape.part = AuditRow::Part::kShape;
  shape.end = {1, 1, 1};
  shape.verdict = "gone";
  return {confirmed, gone, shape};
}

TEST_F(AuditDrawing, LengthsAreThoseOfTheLines) {
  for (const auto& [verdict, length] : lengthsOf(rows()))
    EXPECT_NEAR(length, verdict == "confirmed" ? 4 : verdict == "gone" ? 3 : 0, 1e-9) << verdict;
}

TEST_F(AuditDrawing, APictureShowsEachVerdictInItsColour) {
  const cv::Mat picture = drawAudit(rows(), {400, 300});
  EXPECT_FALSE(test::bounds(test::pixelsOf(picture, {115, 158, 0}, 40)).empty());
  EXPECT_FALSE(test::bounds(test::pixelsOf(picture, {0, 94, 213}, 40)).empty());
  EXPECT_FALSE(drawAudit({}, {400, 300}).empty());
}

TEST_F(AuditDrawing, TheObjHasOneObjectForEachVerdict) {
  const std::string file = path("audit.obj");
  writeAuditObj(file, rows());
  const MeshModel mesh = loadMesh(file, MapParameters());
  EXPECT_EQ(mesh.lines.size(), 2u);
  EXPECT_EQ(mesh.report.objects.size(), 2u);
  EXPECT_EQ(mesh.report.objects.count("gone"), 1u);
}

}  // namespace
}  // namespace edge_mcl
