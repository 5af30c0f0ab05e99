// Tests the compared filters on a simulated flight, and the page about their runs.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "edge_mcl/comparison/compared_methods.h"
#include "edge_mcl/comparison/comparison_plot.h"
#include "edge_mcl/comparison/comparison_report.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/sim/sequence_writer.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

class ComparedRuns : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("edge_mcl_comparison_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    Scenario scenario =
        Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
    scenario.rate = 8;
    Simulator simulator(scenario);
    SequenceWriter writer((folder_ / "flight").string(), simulator.setup(), scenario.model_file,
                          {});
    for (size_t i = 0; i < simulator.imageCount(); ++i) {
      RecordedFrame frame;
      if (simulator.next(&frame)) writer.write(frame);
    }
    writer.close();
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static ComparedRun run(const std::string& method, int particles) {
    return runCompared(method, (folder_ / "flight").string(), 1, particles);
  }
  static fs::path folder_;
};
fs::path ComparedRuns::folder_;

/// The odometry of this flight has an error of 10 cm and more at its end. Every filter must do
/// better. An edge has an error of at most one pixel, which is 2 cm at 4 m with a focal length of
/// 200 pixels.
TEST_F(ComparedRuns, FiltersFollowTheFlight) {
  const ComparedRun odometry = run("dead_reckoning", 0);
  ASSERT_GT(odometry.position.max, 0.05);
  for (const ComparedMethod& m : comparedMethods()) {
    if (!m.hasParticles()) continue;
    const ComparedRun r = run(m.name, 300);
    EXPECT_EQ(r.failure, "") << m.name;
    EXPECT_EQ(r.images, odometry.images) << m.name;
    EXPECT_FALSE(r.lost) << m.name;
    EXPECT_LT(r.position.median, m.kind == MethodKind::kOwn ? 0.02 : 0.15) << m.name;
    EXPECT_GT(r.update_ms.median, 0) << m.name;
    EXPECT_LE(r.plane.median, r.position.median + 1e-12) << m.name;
  }
}

TEST_F(ComparedRuns, ARunIsTheSameTwice) {
  for (const char* method : {"edges", "mrpt_3d", "mrpt_2d"}) {
    const ComparedRun a = run(method, 60), b = run(method, 60);
    EXPECT_EQ(a.position_series, b.position_series) << method;
  }
}

/// Images without ground truth do not count for the success.
TEST_F(ComparedRuns, SuccessIsOfTheImagesWithTruth) {
  const fs::path part = folder_ / "part";
  fs::remove_all(part);
  fs::copy(folder_ / "flight", part, fs::copy_options::recursive);
  std::ifstream all(folder_ / "flight" / "groundtruth.txt");
  std::ofstream few(part / "groundtruth.txt", std::ios::trunc);
  std::string line;
  // Six poses and the header.
  for (int k = 0; k < 7 && std::getline(all, line); ++k) few << line << '\n';
  few.close();
  const ComparedRun r = runCompared("edges", part.string(), 1, 300);
  EXPECT_EQ(r.images, 6u);
  ASSERT_LT(r.position.median, 0.1);
  EXPECT_GE(r.success, 0.5);
}

TEST_F(ComparedRuns, SurviveStorage) {
  const ComparedRun r = run("edges", 50);
  EXPECT_EQ(toJson(runFromJson(toJson(r), "x")), toJson(r));
  EXPECT_THROW(runFromJson({{"method", "edges"}}, "x"), InputError);
}

/// An unknown method and a missing sequence are errors.
TEST_F(ComparedRuns, SayWhatIsWrong) {
  EXPECT_THROW(runCompared("edgse", (folder_ / "flight").string(), 1, 50), ParameterError);
  EXPECT_THROW(runCompared("edges", (folder_ / "nothing").string(), 1, 50), InputError);
}

ComparedRun made(const std::string& method, uint64_t seed, double median, bool lost) {
  ComparedRun r;
  r.method = method;
  r.sequence = "hangar";
  r.seed = seed;
  r.particles = 100;
  r.images = 3;
  r.position = {median, median, median, 2 * median, 2 * median};
  r.plane = r.position;
  r.rotation = {1, 1, 1, 1, 1};
  r.success = lost ? 0 : 1;
  r.lost = lost;
  r.update_ms = {5, 5, 5, 5, 5};
  r.time = {0, 1, 2};
  r.position_series = {median, median, median};
  return r;
}

TEST(ComparisonReport, AveragesOverTheSeeds) {
  const std::vector<ComparedRow> rows =
      rowsOf({made("edges", 1, 0.01, false), made("edges", 2, 0.03, true)});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].runs, 2u);
  EXPECT_EQ(rows[0].lost, 1u);
  EXPECT_NEAR(rows[0].position, 0.02, 1e-12);
  EXPECT_NEAR(rows[0].position_p90, 0.04, 1e-12);
  EXPECT_NEAR(rows[0].success, 0.5, 1e-12);
}

/// The page names MRPT's filter as the winner when its error is smaller.
TEST(ComparisonReport, SaysWhoeverWins) {
  Comparison c;
  c.equal_count = {made("edges", 1, 0.01, false), made("mrpt_2d", 1, 0.05, false)};
  EXPECT_EQ(toMarkdown(c).find("MRPT's filter wins"), std::string::npos);
  c.equal_count = {made("edges", 1, 0.05, true), made("mrpt_2d", 1, 0.01, false)};
  EXPECT_NE(toMarkdown(c).find("MRPT's filter wins"), std::string::npos);
}

TEST(ComparisonReport, AFailureIsNoFigure) {
  ComparedRun failed = made("mrpt_3d", 1, 0, true);
  failed.failure = "an assertion";
  Comparison c;
  c.equal_count = {failed, made("edges", 1, 0.01, false)};
  const std::string text = toMarkdown(c);
  EXPECT_NE(text.find("failed"), std::string::npos);
  EXPECT_EQ(text.find("wins here"), std::string::npos);
}

TEST(ComparisonPlot, DrawsWhatThereIs) {
  const std::vector<ComparedRun> runs = {made("edges", 1, 0.01, false),
                                         made("mrpt_2d", 1, 0.05, false)};
  for (const cv::Mat& picture : {drawAccuracy(rowsOf(runs)), drawErrors(runs), drawErrors({})}) {
    EXPECT_GT(picture.cols, 800);
    double low = 0, high = 0;
    cv::minMaxLoc(picture.reshape(1), &low, &high);
    EXPECT_LT(low, 100);
    EXPECT_EQ(high, 255);
  }
}

}  // namespace
}  // namespace edge_mcl
