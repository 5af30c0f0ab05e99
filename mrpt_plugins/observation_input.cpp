#include "edge_mcl/mrpt_plugins/observation_input.h"

#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/camera_rays.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

namespace edge_mcl {

using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationImage;

namespace {

/// Error about a file of pixels or ranges outside the rawlog. MRPT's own message has many lines.
InputError unreadable(const std::string& origin, const std::string& file) {
  const std::filesystem::path folder = mrpt::img::CImage::getImagesPathBase();
  return InputError(origin + ": " + (folder / file).string() + ": missing or not readable");
}

cv::Mat pixelsOf(const mrpt::img::CImage& image, const std::string& origin) {
  try {
    image.forceLoad();
  } catch (const std::exception&) {
    throw unreadable(origin, image.getExternalStorageFile());
  }
  if (image.isEmpty()) throw InputError(origin + ": the image is empty");
  return image.asCvMatRef();
}

/// Depths along the optical axis (CV_32F, metres) from distances along the rays; 0: no return.
cv::Mat depthFromRanges(const cv::Mat& ranges, const CameraModel& camera, double units_per_metre) {
  cv::Mat depth(ranges.size(), CV_32FC1, cv::Scalar(0));
  for (int y = 0; y < ranges.rows; ++y)
    for (int x = 0; x < ranges.cols; ++x) {
      const uint16_t range = ranges.at<uint16_t>(y, x);
      Eigen::Vector2d ray;
      if (range != 0 && unproject(camera, {x, y}, &ray))
        depth.at<float>(y, x) =
            static_cast<float>(range / units_per_metre / std::sqrt(1 + ray.squaredNorm()));
    }
  return depth;
}

}  // namespace

std::string originOf(const mrpt::obs::CObservation& obs) {
  return "image observation '" + obs.sensorLabel + "'";
}

bool hasImage(const mrpt::obs::CObservation& obs) {
  if (const auto* scan = dynamic_cast<const CObservation3DRangeScan*>(&obs))
    return scan->hasIntensityImage;
  return dynamic_cast<const CObservationImage*>(&obs) != nullptr;
}

bool hasDepth(const mrpt::obs::CObservation& obs) {
  const auto* scan = dynamic_cast<const CObservation3DRangeScan*>(&obs);
  return scan && scan->hasRangeImage;
}

std::optional<ObservedImage> imageOf(const mrpt::obs::CObservation& obs,
                                     const CameraModel* calibration) {
  const auto cameraOf = [&](const mrpt::img::TCamera& own) {
    const bool has_none = own.fx() == 0 && own.fy() == 0;
    if (!has_none) return toCameraModel(own, originOf(obs));
    if (calibration) return *calibration;
    throw InputError(originOf(obs) + ": the image has no calibration, and none was given");
  };
  if (!hasImage(obs)) return std::nullopt;
  const std::string origin = originOf(obs);
  ObservedImage result;
  if (const auto* image = dynamic_cast<const CObservationImage*>(&obs)) {
    result.pixels = pixelsOf(image->image, origin);
    result.camera = cameraOf(image->cameraParams);
    result.T_base_camera = toPose(image->cameraPose);
    const auto* masked = dynamic_cast<const CObservationMaskedImage*>(image);
    if (masked && !masked->ignore_mask.isEmpty())
      result.mask = pixelsOf(masked->ignore_mask, origin);
    return result;
  }
  const auto& scan = dynamic_cast<const CObservation3DRangeScan&>(obs);
  result.pixels = pixelsOf(scan.intensityImage, origin);
  result.camera = cameraOf(scan.cameraParamsIntensity);
  result.T_base_camera = toPose(scan.sensorPose + scan.relativePoseIntensityWRTDepth);
  return result;
}

cv::Mat rangesOf(const mrpt::obs::CObservation& obs) {
  if (!hasDepth(obs)) return {};
  const auto& scan = dynamic_cast<const CObservation3DRangeScan&>(obs);
  try {
    scan.load();
  } catch (const std::exception&) {
    throw unreadable(originOf(obs), scan.rangeImage_getExternalStorageFile(""));
  }
  const auto& ranges = scan.rangeImage;
  if (ranges.rows() == 0) return {};
  return {static_cast<int>(ranges.rows()), static_cast<int>(ranges.cols()), CV_16UC1,
          const_cast<uint16_t*>(ranges.data())};
}

Pose depthMountingOf(const mrpt::obs::CObservation& obs) {
  // In MRPT the frame of the depth sensor has x forward and z up.
  return toPose(dynamic_cast<const CObservation3DRangeScan&>(obs).sensorPose) * opticalOnBody();
}

std::optional<ObservedDepth> depthOf(const mrpt::obs::CObservation& obs) {
  if (!hasDepth(obs)) return std::nullopt;
  const auto& scan = dynamic_cast<const CObservation3DRangeScan&>(obs);
  ObservedDepth result;
  result.image.origin = originOf(obs);
  result.image.camera = toCameraModel(scan.cameraParams, result.image.origin);
  result.T_base_camera = depthMountingOf(obs);
  if (!(scan.rangeUnits > 0))
    throw InputError(result.image.origin +
                     ": the range image has no unit (rangeUnits must be positive)");
  result.image.units_per_metre = 1 / static_cast<double>(scan.rangeUnits);
  const cv::Mat units = rangesOf(obs);
  if (units.empty()) throw InputError(result.image.origin + ": the range image is empty");
  if (scan.range_is_depth) {
    result.image.depth = units.clone();
  } else {
    if (units.cols != result.image.camera.width || units.rows != result.image.camera.height)
      throw InputError(result.image.origin +
                       ": the range image and its camera have different sizes");
    result.image.depth = depthFromRanges(units, result.image.camera, result.image.units_per_metre);
  }
  return result;
}

uint64_t keyOf(const mrpt::obs::CObservation& obs, const cv::Mat& pixels, const cv::Mat& mask) {
  uint64_t hash = 1469598103934665603ull;
  const auto mix = [&](uint64_t v) { hash = (hash ^ v) * 1099511628211ull; };
  mix(reinterpret_cast<uint64_t>(&obs));
  mix(static_cast<uint64_t>(obs.timestamp.time_since_epoch().count()));
  for (const cv::Mat* m : {&pixels, &mask}) {
    mix(reinterpret_cast<uint64_t>(m->data));
    mix(static_cast<uint64_t>(m->rows) << 32 | static_cast<uint64_t>(m->cols));
    if (m->empty()) continue;
    const int row_step = std::max(1, m->rows / 16), column_step = std::max(1, m->cols / 16);
    for (int y = row_step / 2; y < m->rows; y += row_step)
      for (int x = column_step / 2; x < m->cols; x += column_step)
        mix(m->ptr(y)[static_cast<size_t>(x) * m->elemSize()]);
  }
  return hash;
}

uint64_t depthKeyOf(const mrpt::obs::CObservation& obs) {
  uint64_t hash = keyOf(obs, rangesOf(obs), {});
  const auto& scan = dynamic_cast<const CObservation3DRangeScan&>(obs);
  const mrpt::img::TCamera& c = scan.cameraParams;
  std::vector<double> numbers{c.fx(),
                              c.fy(),
                              c.cx(),
                              c.cy(),
                              static_cast<double>(c.ncols),
                              static_cast<double>(c.nrows),
                              static_cast<double>(scan.rangeUnits),
                              scan.range_is_depth ? 1.0 : 0.0};
  numbers.insert(numbers.end(), c.dist.begin(), c.dist.end());
  for (const double number : numbers)
    hash = (hash ^ std::hash<double>()(number)) * 1099511628211ull;
  return hash;
}

}  // namespace edge_mcl
