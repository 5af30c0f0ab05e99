#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"

#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <opencv2/core.hpp>
#include <sstream>

#include "support/error_text.h"
#include "support/mrpt_archive.h"
#include "support/mrpt_room.h"

namespace edge_mcl {
namespace {

TEST(Observation, SerializesWithItsMask) {
  auto obs = test::roomObservation(opticalOnBody());
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask(cv::Rect(10, 20, 30, 40)) = 255;
  obs->ignore_mask = mrpt::img::CImage(mask, mrpt::img::DEEP_COPY);
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << *obs;
  stream.Seek(0);
  const auto read = std::dynamic_pointer_cast<CObservationMaskedImage>(archive.ReadObject());
  ASSERT_TRUE(read);
  EXPECT_EQ(cv::norm(read->ignore_mask.asCvMatRef(), mask), 0);
  EXPECT_EQ(cv::norm(read->image.asCvMatRef(), obs->image.asCvMatRef()), 0);
}

TEST(Observation, SerializesWhatTheImageObservationHolds) {
  const auto obs = test::roomObservation(opticalOnBody());
  obs->sensorLabel = "left";
  obs->timestamp = mrpt::Clock::fromDouble(123.5);
  const auto read = std::dynamic_pointer_cast<CObservationMaskedImage>(test::throughArchive(*obs));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->sensorLabel, "left");
  EXPECT_EQ(read->timestamp, obs->timestamp);
  EXPECT_EQ(read->cameraParams.fx(), obs->cameraParams.fx());
  // The pose is stored as a quaternion or as angles, which costs the last bits.
  EXPECT_TRUE(toPose(read->cameraPose).isApprox(opticalOnBody(), 1e-9));
  EXPECT_TRUE(read->ignore_mask.isEmpty());
}

/// An object that is used again must lose the mask of the observation before.
TEST(Observation, WithoutAMaskTheOldMaskIsForgotten) {
  const auto bare = test::roomObservation(opticalOnBody());
  CObservationMaskedImage reused;
  reused.ignore_mask =
      mrpt::img::CImage(cv::Mat(240, 320, CV_8U, cv::Scalar(255)), mrpt::img::DEEP_COPY);
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << *bare;
  stream.Seek(0);
  archive >> reused;
  EXPECT_TRUE(reused.ignore_mask.isEmpty());
  EXPECT_EQ(reused.image.getWidth(), 320u);
}

TEST(Observation, AVersionOfTheFutureIsAnError) {
  test::expectError<std::exception>("unknown serialization version number: '1'", [] {
    test::fromArchive("edge_mcl::CObservationMaskedImage", 1, [](auto&) {});
  });
}

TEST(Observation, ItsDescriptionTellsOfTheMask) {
  const auto obs = test::roomObservation(opticalOnBody());
  std::ostringstream bare, masked;
  obs->getDescriptionAsText(bare);
  obs->ignore_mask =
      mrpt::img::CImage(cv::Mat(240, 320, CV_8U, cv::Scalar(255)), mrpt::img::DEEP_COPY);
  obs->getDescriptionAsText(masked);
  EXPECT_PRED2(test::contains, bare.str(), "Ignore mask: none");
  EXPECT_PRED2(test::contains, masked.str(), "Ignore mask: yes");
}

}  // namespace
}  // namespace edge_mcl
