// Objects and background move in known ways, so the true masks are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/detector/object_tracker.h"

namespace edge_mcl {
namespace {

constexpr int kWidth = 320, kHeight = 240;

cv::Mat texture(const cv::Size& size, uint64_t seed, const cv::Scalar& low,
                const cv::Scalar& high) {
  cv::RNG random(seed);
  cv::Mat small(size.height / 8 + 2, size.width / 8 + 2, CV_8UC3), large;
  random.fill(small, cv::RNG::UNIFORM, low, high);
  cv::resize(small, large, {}, 8, 8, cv::INTER_CUBIC);
  return large(cv::Rect({}, size)).clone();
}

/// A textured wall that shifts with the camera, and a box of other colours in front of it.
struct Stage {
  cv::Mat wall = texture({3 * kWidth, 2 * kHeight}, 1, {0, 0, 0}, {255, 255, 255});
  cv::Mat box = texture({70, 90}, 2, {0, 0, 120}, {60, 90, 255});

  /// @param box_at place of the box; far outside the image no box is drawn
  cv::Mat image(const cv::Point& wall_at, const cv::Point& box_at) const {
    cv::Mat picture = wall(cv::Rect(wall_at, cv::Size(kWidth, kHeight))).clone();
    const cv::Rect seen = cv::Rect(box_at, box.size()) & cv::Rect(0, 0, kWidth, kHeight);
    if (seen.area() > 0) box(seen - box_at).copyTo(picture(seen));
    return picture;
  }
  cv::Mat mask(const cv::Point& box_at) const {
    cv::Mat m = cv::Mat::zeros(kHeight, kWidth, CV_8U);
    const cv::Rect seen = cv::Rect(box_at, box.size()) & cv::Rect(0, 0, kWidth, kHeight);
    if (seen.area() > 0) m(seen) = 255;
    return m;
  }
  Detections found(const cv::Point& box_at) const {
    Detection d;
    d.class_id = 1;
    d.score = 0.9f;
    d.mask = mask(box_at);
    d.box = cv::boundingRect(d.mask);
    return {d};
  }
};

DetectorParameters exact() {
  DetectorParameters p;
  p.dilation = 0;
  p.dilation_growth = 0;
  return p;
}

TEST(ObjectTracker, NothingFoundIsAnEmptyMask) {
  ObjectTracker tracker(exact());
  const Stage stage;
  tracker.advance(stage.image({100, 50}, {100, 80}), 0);
  EXPECT_TRUE(tracker.confirm(0, {}));
  EXPECT_EQ(tracker.mask().size(), cv::Size(kWidth, kHeight));
  EXPECT_EQ(cv::countNonZero(tracker.mask()), 0);
  EXPECT_TRUE(tracker.objects().empty());
}

TEST(ObjectTracker, AnObjectThatMovesOtherThanTheBackground) {
  ObjectTracker tracker(exact());
  const Stage stage;
  const auto boxAt = [](int i) { return cv::Point(60 + 4 * i, 70 + i); };
  for (int i = 0; i <= 12; ++i) {
    tracker.advance(stage.image({100 + 2 * i, 50}, boxAt(i)), 0.066 * i);
    if (i == 0) {
      ASSERT_TRUE(tracker.confirm(0, stage.found(boxAt(0))));
    }
  }
  // The tolerance is half a pixel of drift on each side of 70 x 90 pixels.
  EXPECT_GT(maskOverlap(tracker.mask(), stage.mask(boxAt(12))), 0.96);
  ASSERT_EQ(tracker.objects().size(), 1u);
  EXPECT_NEAR(tracker.objects()[0].age, 12 * 0.066, 1e-9);
  EXPECT_LT(tracker.objects()[0].score, 0.9f);
}

/// The result belongs to the third image and comes after the ninth.
TEST(ObjectTracker, AResultThatComesLateIsCarriedToNow) {
  ObjectTracker tracker(exact());
  const Stage stage;
  const auto boxAt = [](int i) { return cv::Point(60 + 3 * i, 70); };
  for (int i = 0; i <= 8; ++i) tracker.advance(stage.image({100, 50}, boxAt(i)), 0.066 * i);
  ASSERT_TRUE(tracker.confirm(0.066 * 2, stage.found(boxAt(2))));
  EXPECT_GT(maskOverlap(tracker.mask(), stage.mask(boxAt(8))), 0.96);
}

TEST(ObjectTracker, AResultOfAHundredImagesAgoIsCarriedToNow) {
  ObjectTracker tracker(exact());
  const Stage stage;
  const auto boxAt = [](int i) { return cv::Point(60 + i, 70); };
  for (int i = 0; i <= 100; ++i) {
    tracker.advance(stage.image({100, 50}, boxAt(i)), 0.03 * i);
    if (i == 0) tracker.hold();
  }
  ASSERT_TRUE(tracker.confirm(0, stage.found(boxAt(0))));
  // The box has moved by more than its width. Thirty steps of tracking can turn the mask by a few
  // degrees.
  EXPECT_GT(maskOverlap(tracker.mask(), stage.mask(boxAt(100))), 0.7);
}

TEST(ObjectTracker, WithoutCornersItMovesWithTheBackground) {
  ObjectTracker tracker(exact());
  Stage stage;
  // A box of one colour; its outline is blurred below, so it has no corners.
  stage.box = cv::Scalar(0, 0, 200);
  const auto imageOf = [&](int i) {
    cv::Mat picture = stage.image({100 + 3 * i, 50}, {120 - 3 * i, 80});
    cv::Mat soft;
    cv::GaussianBlur(picture, soft, {0, 0}, 12);
    const cv::Rect around(120 - 3 * i - 25, 55, 120, 140);
    soft(around).copyTo(picture(around));
    return picture;
  };
  for (int i = 0; i <= 8; ++i) {
    tracker.advance(imageOf(i), 0.066 * i);
    if (i == 0) {
      ASSERT_TRUE(tracker.confirm(0, stage.found({120, 80})));
    }
  }
  EXPECT_GT(maskOverlap(tracker.mask(), stage.mask({96, 80})), 0.9);
}

TEST(ObjectTracker, KeepsItsNumberAndKnowsItAgain) {
  DetectorParameters parameters = exact();
  parameters.half_life = 0.2;
  ObjectTracker tracker(parameters);
  const Stage stage;
  double time = 0;
  const auto look = [&](const cv::Point& at) {
    time += 0.1;
    tracker.advance(stage.image({100, 50}, at), time);
    tracker.confirm(time, stage.mask(at).empty() || cv::countNonZero(stage.mask(at)) == 0
                              ? Detections()
                              : stage.found(at));
  };
  look({60, 70});
  const int first = tracker.objects().at(0).track_id;
  look({66, 70});
  EXPECT_EQ(tracker.objects().at(0).track_id, first) << "confirmed";
  for (int i = 0; i < 5; ++i) look({-500, 0});
  EXPECT_TRUE(tracker.objects().empty());
  look({200, 90});
  ASSERT_EQ(tracker.objects().size(), 1u);
  EXPECT_EQ(tracker.objects()[0].track_id, first) << "came back elsewhere";
  // Another object has the same class but other colours.
  for (int i = 0; i < 5; ++i) look({-500, 0});
  Stage other;
  other.box = texture({70, 90}, 3, {150, 60, 0}, {255, 120, 40});
  time += 0.1;
  tracker.advance(other.image({100, 50}, {60, 70}), time);
  tracker.confirm(time, other.found({60, 70}));
  ASSERT_EQ(tracker.objects().size(), 1u);
  EXPECT_NE(tracker.objects()[0].track_id, first);
}

TEST(ObjectTracker, UnconfirmedObjectsFade) {
  DetectorParameters parameters = exact();
  parameters.half_life = 0.5;
  parameters.min_confidence = 0.2;
  ObjectTracker tracker(parameters);
  const Stage stage;
  tracker.advance(stage.image({100, 50}, {100, 80}), 0);
  tracker.confirm(0, stage.found({100, 80}));
  double gone = 0;
  for (int i = 1; i < 60 && gone == 0; ++i) {
    tracker.advance(stage.image({100, 50}, {100, 80}), 0.05 * i);
    if (tracker.objects().empty()) gone = 0.05 * i;
  }
  // When every corner is followed, 0.9 * 0.5^(t / 0.5) falls to 0.2 at 1.085 s.
  EXPECT_NEAR(gone, 1.1, 0.1);
}

/// Without corners the confidence must fall equally at 15 and at 60 images per second.
TEST(ObjectTracker, ConfidenceIsLostByTimeNotByImages) {
  DetectorParameters parameters = exact();
  parameters.half_life = 1;
  parameters.min_confidence = 0;
  const cv::Mat flat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(90));  // no corners to follow
  for (const int rate : {15, 60}) {
    ObjectTracker tracker(parameters);
    tracker.advance(flat, 0);
    tracker.confirm(0, Stage().found({100, 80}));
    for (int i = 1; i <= rate; ++i) tracker.advance(flat, static_cast<double>(i) / rate);
    ASSERT_EQ(tracker.objects().size(), 1u);
    EXPECT_NEAR(tracker.objects()[0].score, 0.9 * 0.5 * std::pow(0.8, 15), 1e-5) << rate;
  }
}

/// The mask grows by 2 pixels, and by 10 pixels per second.
TEST(ObjectTracker, TheMaskGrowsWithAge) {
  DetectorParameters parameters;
  parameters.dilation = 2;
  parameters.dilation_growth = 10;
  ObjectTracker tracker(parameters);
  const Stage stage;
  tracker.advance(stage.image({100, 50}, {100, 80}), 0);
  tracker.confirm(0, stage.found({100, 80}));
  EXPECT_EQ(cv::boundingRect(tracker.mask()), cv::Rect(98, 78, 74, 94));
  tracker.advance(stage.image({100, 50}, {100, 80}), 0.5);
  EXPECT_EQ(cv::boundingRect(tracker.mask()), cv::Rect(93, 73, 84, 104));
}

TEST(ObjectTracker, AGapOfHoursMasksTheImageAndNoMore) {
  DetectorParameters parameters;
  parameters.min_confidence = 0;
  ObjectTracker tracker(parameters);
  const Stage stage;
  tracker.advance(stage.image({100, 50}, {100, 80}), 0);
  tracker.confirm(0, stage.found({100, 80}));
  tracker.advance(stage.image({100, 50}, {100, 80}), 1e4);
  EXPECT_EQ(cv::countNonZero(tracker.mask()), kWidth * kHeight);
}

TEST(ObjectTracker, MasksOfNarrowImagesGrowInProportion) {
  DetectorParameters parameters;
  parameters.dilation = 4;
  ObjectTracker tracker(parameters);
  tracker.advance(cv::Mat(kHeight / 2, kWidth / 2, CV_8U, cv::Scalar(90)), 0);
  Detection found;
  found.score = 0.9f;
  found.mask = cv::Mat::zeros(kHeight / 2, kWidth / 2, CV_8U);
  found.mask(cv::Rect(50, 40, 30, 20)) = 255;
  ASSERT_TRUE(tracker.confirm(0, {found}));
  EXPECT_EQ(cv::boundingRect(tracker.mask()), cv::Rect(48, 38, 34, 24));
}

TEST(ObjectTracker, TwoObjectsOutOfSightAreNotOne) {
  DetectorParameters parameters = exact();
  parameters.min_confidence = 0;
  ObjectTracker tracker(parameters);
  const Stage stage;
  // Both objects stand on the wall. The wall moves to the left and back again.
  for (int i = 0; i <= 16; ++i) {
    tracker.advance(stage.image({100 + 20 * std::min(i, 16 - i), 50}, {-500, 0}), 0.066 * i);
    if (i == 0) tracker.confirm(0, stage.found({10, 120}));
    if (i != 8) continue;
    EXPECT_TRUE(tracker.objects().empty());
    ASSERT_TRUE(tracker.confirm(0.066, stage.found({20, 10})));
    EXPECT_TRUE(tracker.objects().empty());
  }
  ASSERT_EQ(tracker.objects().size(), 2u);
  EXPECT_NE(tracker.objects()[0].track_id, tracker.objects()[1].track_id);
}

/// A late image and a repeated image are errors and change nothing. Another size or a jump of the
/// clock starts the tracker anew.
TEST(ObjectTracker, ALateImageIsNotTaken) {
  ObjectTracker tracker(exact());
  const Stage stage;
  const cv::Mat image = stage.image({100, 50}, {100, 80});
  EXPECT_TRUE(tracker.advance(image, 10));
  tracker.confirm(10, stage.found({100, 80}));
  const int id = tracker.objects().at(0).track_id;
  EXPECT_THROW(tracker.advance(image, 9.99), InputError);
  EXPECT_THROW(tracker.advance(image, 10), InputError) << "repeated";
  EXPECT_FALSE(tracker.advance(image, 10.07));
  ASSERT_EQ(tracker.objects().size(), 1u);
  EXPECT_EQ(tracker.objects()[0].track_id, id);
  cv::Mat larger;
  cv::resize(image, larger, {}, 2, 2);
  EXPECT_TRUE(tracker.advance(larger, 10.2)) << "another size";
  EXPECT_TRUE(tracker.advance(larger, 9.1)) << "a jump back";
}

TEST(ObjectTracker, TimeThatGoesBackStartsAnew) {
  ObjectTracker tracker(exact());
  const Stage stage;
  tracker.advance(stage.image({100, 50}, {100, 80}), 10);
  tracker.confirm(10, stage.found({100, 80}));
  tracker.advance(stage.image({100, 50}, {100, 80}), 5);
  EXPECT_TRUE(tracker.objects().empty());
  EXPECT_FALSE(tracker.confirm(10, stage.found({100, 80}))) << "an image of another time";
  EXPECT_TRUE(tracker.confirm(5, stage.found({100, 80})));
}

TEST(ObjectTracker, LargerImagesAndGreyOnes) {
  ObjectTracker tracker(exact());
  const Stage stage;
  cv::Mat large, grey;
  for (int i = 0; i < 5; ++i) {
    cv::resize(stage.image({100, 50}, {100 + 2 * i, 80}), large, {}, 2, 2);
    cv::cvtColor(large, grey, cv::COLOR_BGR2GRAY);
    tracker.advance(grey, 0.1 * i);
    Detections found = stage.found({100, 80});
    cv::resize(found[0].mask, found[0].mask, {}, 2, 2, cv::INTER_NEAREST);
    if (i == 0) tracker.confirm(0, found);
  }
  cv::Mat expected;
  cv::resize(stage.mask({108, 80}), expected, {}, 2, 2, cv::INTER_NEAREST);
  EXPECT_GT(maskOverlap(tracker.mask(), expected), 0.95);
  EXPECT_THROW(tracker.advance(cv::Mat(), 9), InputError);
}

/// The truth is OpenCV's dilation with an ellipse.
TEST(Masks, GrowByADisc) {
  for (int radius = 1; radius <= 12; ++radius) {
    cv::Mat mask = cv::Mat::zeros(60, 80, CV_8U), expected;
    mask.at<uint8_t>(30, 40) = 255;
    mask(cv::Rect(8, 50, 7, 3)) = 255;
    const cv::Size size(2 * radius + 1, 2 * radius + 1);
    cv::dilate(mask, expected, cv::getStructuringElement(cv::MORPH_ELLIPSE, size));
    dilateMask(radius, &mask);
    EXPECT_EQ(cv::countNonZero(mask != expected), 0) << radius;
  }
}

TEST(Masks, GrowByAnyLength) {
  cv::Mat mask = cv::Mat::zeros(300, 400, CV_8U);
  dilateMask(100, &mask);
  EXPECT_EQ(cv::countNonZero(mask), 0) << "nothing stays nothing";
  mask.at<uint8_t>(150, 200) = 255;
  dilateMask(100, &mask);
  EXPECT_EQ(cv::boundingRect(mask), cv::Rect(100, 50, 201, 201));
  EXPECT_EQ(mask.at<uint8_t>(150 + 70, 200 + 70), 255);
  EXPECT_EQ(mask.at<uint8_t>(150 + 71, 200 + 71), 0);
  dilateMask(1000000, &mask);
  EXPECT_EQ(cv::countNonZero(mask), 300 * 400);
}

}  // namespace
}  // namespace edge_mcl
