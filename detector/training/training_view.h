/// Renders images of a training room with their labels.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/detector/training/training_room.h"

namespace edge_mcl {

/// An image and the label of every pixel.
struct TrainingImage {
  cv::Mat color;  ///< CV_8UC3, blue green red
  cv::Mat label;  ///< CV_8U, number of the class
};

/// A room in the ray caster.
class TrainingView {
 public:
  /// @param room must outlive this object. @param device of the objects' scenes.
  TrainingView(const TrainingRoom& room, RTCDevice device);
  ~TrainingView();
  TrainingView(const TrainingView&) = delete;
  TrainingView& operator=(const TrainingView&) = delete;

  /// Renders an image from a random place in the room, as a small UAV sees it. 80 % of the images
  /// look towards a movable object, if there is one. @param width, height pixels.
  TrainingImage take(TrainingRandom& random, int width, int height) const;

 private:
  struct Camera {
    Eigen::Vector3f eye;
    Eigen::Matrix3f rotation;
    float focal;  // focal length of the oversampled image, pixels
  };
  struct Sample {
    Eigen::Vector3f color;
    uint8_t label;
  };
  Camera randomCamera(TrainingRandom& random, int width) const;
  void sampleTile(const Camera& camera, const cv::Size& size, const cv::Point& corner,
                  Sample* samples) const;
  Eigen::Vector3f shade(const Eigen::Vector3f& eye, const Eigen::Vector3f& direction,
                        float distance, unsigned part, unsigned face, uint8_t* label) const;
  bool blocked(const Eigen::Vector3f& from, const Eigen::Vector3f& to) const;

  const TrainingRoom& room_;
  std::vector<Eigen::Vector3f> normals_;  // of the faces of the room's mesh
  RTCScene walls_ = nullptr, top_ = nullptr;
  std::vector<RTCGeometry> instances_;
};

}  // namespace edge_mcl
