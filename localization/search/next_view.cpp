#include "edge_mcl/localization/search/next_view.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/places/free_space.h"

namespace edge_mcl {

namespace {

/// Heading of a pose: the direction of the camera in the horizontal plane, rad. A camera that looks
/// straight up or down has the heading of its upper image border.
double headingOf(const Pose& pose, const Pose& T_base_camera) {
  const Eigen::Matrix3d camera = (pose * T_base_camera).linear();
  constexpr double kLevel = 0.2;  // horizontal part of the optical axis, about 12 degrees
  Eigen::Vector3d forward = camera.col(2);
  if (std::hypot(forward.x(), forward.y()) < kLevel) forward = -camera.col(1);
  return std::atan2(forward.y(), forward.x());
}

/// A motion in the level frame of a heading.
struct Motion {
  Eigen::Vector2d shift;  // m, forward and left
  double turn = 0;        // rad
};

Pose after(const Motion& motion, const Pose& pose, double heading) {
  Pose result = pose;
  result.linear() =
      Eigen::AngleAxisd(motion.turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * pose.linear();
  result.translation().head<2>() += Eigen::Rotation2Dd(heading) * motion.shift;
  return result;
}

/// Coarse picture of lines: which boxes of the image hold a part of one.
class LineRaster {
 public:
  LineRaster() : boxes_(cv::Mat::zeros(kHeight, kWidth, CV_8U)) {}

  void add(const CameraModel& camera, const Eigen::Vector2d& pixel) {
    const int x = std::min(kWidth - 1, static_cast<int>(pixel.x() * kWidth / camera.width));
    const int y = std::min(kHeight - 1, static_cast<int>(pixel.y() * kHeight / camera.height));
    boxes_.at<uint8_t>(y, x) = 1;
  }
  int count() const { return cv::countNonZero(boxes_); }
  /// Number of boxes of this picture that have no neighbour in the other one.
  int without(const LineRaster& other) const {
    cv::Mat near;
    cv::dilate(other.boxes_, near, cv::Mat::ones(3, 3, CV_8U));
    return cv::countNonZero(boxes_ > near);
  }

 private:
  // A box is 1/48 of the image wide, about one degree. Both places are known that well.
  static constexpr int kWidth = 48, kHeight = 36;

  cv::Mat boxes_;
};

/// How much the views after one motion differ.
struct Difference {
  int alone = 0, all = 0;  // boxes with lines that only one place shows; boxes with lines
};

/// Compares both places after motions with the same shift.
class PlaceComparison {
 public:
  PlaceComparison(const LocalizationMap& map, const std::vector<const CameraView*>& cameras,
                  const Pose& first, const Pose& second)
      : map_(map), cameras_(cameras) {
    places_[0] = {first, headingOf(first, cameras.front()->T_base_camera)};
    places_[1] = {second, headingOf(second, cameras.front()->T_base_camera)};
  }

  Pose moved(int place, const Motion& motion) const {
    return after(motion, places_[place].pose, places_[place].heading);
  }

  /// Whether the way is free in both places.
  bool isFree(const FreeSpace& space, const Motion& motion) const {
    constexpr double kStep = 0.25;  // m, less than twice the clearance
    const int steps = static_cast<int>(std::ceil(motion.shift.norm() / kStep));
    for (int place = 0; place < 2; ++place)
      for (int i = 1; i <= steps; ++i) {
        const Pose pose = moved(place, {motion.shift * i / steps, 0});
        if (!space.contains((pose * cameras_.front()->T_base_camera).translation())) return false;
      }
    return true;
  }

  Difference compare(const Motion& motion) const {
    Difference result;
    for (const CameraView* camera : cameras_) {
      const LineRaster a = raster(*camera, moved(0, motion)), b = raster(*camera, moved(1, motion));
      result.alone += a.without(b) + b.without(a);
      result.all += a.count() + b.count();
    }
    return result;
  }

 private:
  struct Place {
    Pose pose;
    double heading = 0;
  };

  LineRaster raster(const CameraView& view, const Pose& base) const {
    const CameraModel& camera = view.image->frame.camera;
    const Pose pose = base * view.T_base_camera, to_camera = pose.inverse();
    ViewCone cone;
    cone.axis = pose.linear().col(2).cast<float>();
    cone.angle = static_cast<float>(std::min(M_PI, camera.view.angle));
    const VisibleSet visible = map_.visibility().exact(pose.translation(), 1, cone);
    LineRaster result;
    Eigen::Vector2d pixel;
    for (const VisibleSet::Segment& s : visible.segments)
      for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i) {
        if ((s.samples >> i & 1) == 0) continue;
        const Eigen::Vector3d point = visible.model->samplePosition(visible.edgeSegment(s), i);
        if (camera.project(to_camera * point, &pixel) && camera.contains(pixel))
          result.add(camera, pixel);
      }
    return result;
  }

  const LocalizationMap& map_;
  std::vector<const CameraView*> cameras_;
  Place places_[2];
};

/// All motions that are tried, shortest first.
std::vector<Motion> motions() {
  constexpr int kEighths = 8;
  constexpr double kTurn = 2 * M_PI / kEighths;
  std::vector<Eigen::Vector2d> shifts = {Eigen::Vector2d::Zero()};
  for (const double distance : {0.7, 1.5, 3.0, 5.0})
    for (int way = 0; way < kEighths; ++way)
      shifts.emplace_back(distance * std::cos(way * kTurn), distance * std::sin(way * kTurn));
  std::vector<Motion> all;
  for (const Eigen::Vector2d& shift : shifts)
    for (const int eighths : {0, 1, -1, 2, -2, 3, -3, 4}) all.push_back({shift, eighths * kTurn});
  return all;
}

}  // namespace

NextView::Step NextView::stepFrom(const Pose& now, const Pose& T_base_camera) const {
  const double from = headingOf(now, T_base_camera), to = headingOf(first, T_base_camera);
  Step step;
  step.shift = Eigen::AngleAxisd(-from, Eigen::Vector3d::UnitZ()) *
               (first.translation() - now.translation());
  step.turn = std::remainder(to - from, 2 * M_PI);
  return step;
}

std::optional<NextView> nextView(const LocalizationMap& map, const std::vector<CameraView>& views,
                                 const Pose& first, const Pose& second) {
  // Fewer different boxes than this are errors of the two poses. It is the length of a line of a
  // sixth of the image.
  constexpr int kFewest = 8;
  // The shortest motion that shows so much of the best difference is taken.
  constexpr double kNearlyAll = 0.7;
  std::vector<const CameraView*> cameras;
  for (const CameraView& view : views)
    if (view.image) cameras.push_back(&view);
  if (cameras.empty()) return std::nullopt;
  const PlaceComparison comparison(map, cameras, first, second);
  const std::shared_ptr<const FreeSpace> space = map.freeSpace();
  const std::vector<Motion> tried = motions();
  std::vector<Difference> differences(tried.size());
  tbb::parallel_for(size_t{0}, tried.size(), [&](size_t i) {
    if (comparison.isFree(*space, tried[i])) differences[i] = comparison.compare(tried[i]);
  });
  const auto best =
      std::max_element(differences.begin(), differences.end(),
                       [](const Difference& a, const Difference& b) { return a.alone < b.alone; });
  if (best->alone < kFewest) return std::nullopt;
  const auto chosen =
      std::find_if(differences.begin(), differences.end(),
                   [&](const Difference& d) { return d.alone >= kNearlyAll * best->alone; });
  const Motion& motion = tried[static_cast<size_t>(chosen - differences.begin())];
  return NextView{comparison.moved(0, motion), comparison.moved(1, motion),
                  static_cast<double>(chosen->alone) / chosen->all};
}

}  // namespace edge_mcl
