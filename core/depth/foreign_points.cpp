#include "edge_mcl/core/depth/foreign_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/camera/camera_rays.h"

namespace edge_mcl {

namespace {

/// Examined pixels over the width of an image. Legs of chairs are still two of them wide, and the
/// whole costs about two milliseconds.
constexpr int kAcross = 160;
/// Every second examined pixel has a ray of its own in the model.
constexpr int kPixelsPerRay = 2;
constexpr double kSigmas = 3;

/// The depth of the model on a coarse grid of the image.
class ExpectedDepth {
 public:
  /// @param step of the grid, pixels
  ExpectedDepth(const CameraModel& camera, int step, const RayScene& scene, const Pose& T_map_depth)
      : step_(step),
        columns_((camera.width - 1) / step + 2),
        rows_((camera.height - 1) / step + 2),
        inverse_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_)) {
    const Eigen::Matrix3f rotation = T_map_depth.linear().cast<float>();
    std::vector<Eigen::Vector3f> directions(inverse_.size());
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x) {
        Eigen::Vector2d ray;
        Eigen::Vector3f& direction = directions[index(x, y)];
        if (unproject(camera, {x * step, y * step}, &ray))
          direction = rotation * Eigen::Vector3f(static_cast<float>(ray.x()),
                                                 static_cast<float>(ray.y()), 1.0F);
        else
          direction.setConstant(std::numeric_limits<float>::quiet_NaN());
      }
    firstHits(scene.get(), T_map_depth.translation().cast<float>(), directions.data(),
              directions.size(), inverse_.data());
    for (float& depth : inverse_) depth = 1 / depth;
    is_flat_.resize(inverse_.size());
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x) is_flat_[index(x, y)] = isFlat(x, y);
  }

  /// What the model may have at a pixel.
  struct Surface {
    double nearest = 0, farthest = 0;  ///< m; infinite: no surface
    double slope = 0;                  ///< m per pixel
  };
  Surface at(int x, int y) const {
    const int column = x / step_, row = y / step_;
    if (is_flat_[index(column, row)] && is_flat_[index(column + 1, row)] &&
        is_flat_[index(column, row + 1)] && is_flat_[index(column + 1, row + 1)])
      return onPlane(x, y);
    // Between surfaces all around count.
    float nearest = 0, farthest = std::numeric_limits<float>::infinity();
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 2); ++r)
      for (int q = std::max(0, column - 1); q <= std::min(columns_ - 1, column + 2); ++q) {
        nearest = std::max(nearest, inverse_[index(q, r)]);
        farthest = std::min(farthest, inverse_[index(q, r)]);
      }
    return {1 / static_cast<double>(nearest), 1 / static_cast<double>(farthest), 0};
  }

  /// Whether the model has a surface between two depths (m) within some pixels around a pixel.
  bool hasSurfaceNear(int x, int y, double pixels, double nearest, double farthest) const {
    constexpr int kMost = 2;  // nodes; a strip that is wider is no edge that moved a little
    const int reach = std::min(kMost, static_cast<int>(pixels) / step_), column = x / step_,
              row = y / step_;
    const auto least = static_cast<float>(1 / farthest), most = static_cast<float>(1 / nearest);
    for (int r = std::max(0, row - reach); r <= std::min(rows_ - 1, row + 1 + reach); ++r)
      for (int q = std::max(0, column - reach); q <= std::min(columns_ - 1, column + 1 + reach);
           ++q)
        if (inverse_[index(q, r)] >= least && inverse_[index(q, r)] <= most) return true;
    return false;
  }

 private:
  Surface onPlane(int x, int y) const {
    const int column = x / step_, row = y / step_;
    const float a = inverse_[index(column, row)], by_x = inverse_[index(column + 1, row)] - a,
                by_y = inverse_[index(column, row + 1)] - a;
    const float u = static_cast<float>(x - column * step_) / static_cast<float>(step_),
                v = static_cast<float>(y - row * step_) / static_cast<float>(step_);
    const double inverse = static_cast<double>(a + u * by_x + v * by_y);
    const double by_pixel = static_cast<double>(std::hypot(by_x, by_y)) / step_;
    return {1 / inverse, 1 / inverse, by_pixel / (inverse * inverse)};
  }
  /// Whether a node and its neighbours lie on one plane. There the inverse depth is an affine
  /// function of the pixel. Distortion bends it by less than the limit.
  bool isFlat(int x, int y) const {
    constexpr float kPlane = 0.003F;
    const int left = std::min(std::max(x, 1), columns_ - 2) - 1,
              top = std::min(std::max(y, 1), rows_ - 2) - 1;
    const auto bend = [&](float before, float here, float after) {
      return before > 0 && here > 0 && after > 0 &&
             std::abs(before + after - 2 * here) < 2 * kPlane * here;
    };
    return bend(inverse_[index(left, y)], inverse_[index(left + 1, y)],
                inverse_[index(left + 2, y)]) &&
           bend(inverse_[index(x, top)], inverse_[index(x, top + 1)], inverse_[index(x, top + 2)]);
  }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(columns_) + static_cast<size_t>(x);
  }
  int step_, columns_, rows_;
  std::vector<float> inverse_;  // 1/m; 0: no surface
  std::vector<bool> is_flat_;
};

/// Leaves out regions that are nowhere three pixels wide. @param foreign CV_8U
void removeThin(cv::Mat* foreign) {
  cv::Mat wide, labels;
  cv::erode(*foreign, wide, cv::Mat::ones(3, 3, CV_8U));
  const int count = cv::connectedComponents(*foreign, labels, 8, CV_32S);
  std::vector<bool> is_wide(static_cast<size_t>(count), false);
  for (int y = 0; y < wide.rows; ++y)
    for (int x = 0; x < wide.cols; ++x)
      if (wide.at<uint8_t>(y, x)) is_wide[static_cast<size_t>(labels.at<int>(y, x))] = true;
  for (int y = 0; y < wide.rows; ++y)
    for (int x = 0; x < wide.cols; ++x)
      if (!is_wide[static_cast<size_t>(labels.at<int>(y, x))]) foreign->at<uint8_t>(y, x) = 0;
}

/// @param chosen CV_8U. @param step distance of its pixels in the depth image.
std::vector<Eigen::Vector3f> pointsOf(const DepthImage& image, const cv::Mat& chosen, int step) {
  std::vector<Eigen::Vector3f> points;
  for (int row = 0; row < chosen.rows; ++row)
    for (int column = 0; column < chosen.cols; ++column) {
      Eigen::Vector2d ray;
      if (!chosen.at<uint8_t>(row, column) ||
          !unproject(image.camera, {column * step, row * step}, &ray))
        continue;
      const double depth = metresAt(image, column * step, row * step);
      points.push_back((depth * Eigen::Vector3d(ray.x(), ray.y(), 1)).cast<float>());
    }
  return points;
}

}  // namespace

ForeignPoints foreignPoints(const DepthImage& image, const RayScene& scene,
                            const PoseGaussian& T_map_depth, const DepthParameters& params,
                            double least, bool lists_model) {
  checkDepth(image);
  const CameraModel& camera = image.camera;
  const int step = std::max(1, camera.width / kAcross);
  const ExpectedDepth expected(camera, step * kPixelsPerRay, scene, T_map_depth.mean);
  const Vector6 variance = T_map_depth.covariance.diagonal().cwiseMax(0);
  const double position = std::sqrt(variance.head<3>().maxCoeff());
  const double turn = std::sqrt(variance.tail<3>().maxCoeff());
  const double focal = std::max(camera.fx, camera.fy);

  ForeignPoints result;
  result.spacing = step;
  const cv::Size size((camera.width - 1) / step + 1, (camera.height - 1) / step + 1);
  cv::Mat foreign(size, CV_8U, cv::Scalar(0)), of_model(size, CV_8U, cv::Scalar(0));
  for (int row = 0; row < size.height; ++row)
    for (int column = 0; column < size.width; ++column) {
      const double depth = metresAt(image, column * step, row * step);
      if (!(depth > 0) || depth > params.max_range) continue;
      const ExpectedDepth::Surface model = expected.at(column * step, row * step);
      if (!std::isfinite(model.nearest)) continue;
      ++result.compared;
      // A turn, and a motion to the side, move the surface in the image.
      const double pixels = focal * (turn + position / model.nearest);
      const double noise =
          std::hypot(params.sigma, params.sigma_per_square_metre * model.nearest * model.nearest);
      const double reach = kSigmas * std::hypot(noise, std::hypot(position, model.slope * pixels));
      // A surface at the depth of this pixel moves farther in the image than one behind it.
      const double moved = kSigmas * focal * (turn + position / depth);
      if (depth < model.nearest - least - reach &&
          !expected.hasSurfaceNear(column * step, row * step, moved,
                                   std::max(0.01, depth - least - reach), depth + least + reach))
        foreign.at<uint8_t>(row, column) = 255;
      else if (std::min(std::abs(depth - model.nearest), std::abs(depth - model.farthest)) <
               least / 2 + reach)
        of_model.at<uint8_t>(row, column) = 255;
    }
  const size_t others = result.compared - static_cast<size_t>(cv::countNonZero(foreign));
  if (others > 0) result.agreement = cv::countNonZero(of_model) / static_cast<double>(others);
  removeThin(&foreign);
  result.points = pointsOf(image, foreign, step);
  if (lists_model) result.of_model = pointsOf(image, of_model, step);
  return result;
}

}  // namespace edge_mcl
