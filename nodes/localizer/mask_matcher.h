/// Joins every image with its mask, or decides that no mask will come.
#pragma once

#include <sensor_msgs/Image.h>

#include <deque>
#include <optional>

namespace edge_mcl {

/// Gives out the newest complete image and drops older ones. With masks an image is complete when
/// the mask of the same stamp has come, or when the image has waited for `timeout`. Not
/// thread-safe.
class MaskMatcher {
 public:
  struct Match {
    sensor_msgs::ImageConstPtr image;
    sensor_msgs::ImageConstPtr mask;  ///< null: none came in time, or none is wanted
  };

  /// @param timeout s, on the clock of `now` below
  MaskMatcher(bool use_masks, double timeout) : use_masks_(use_masks), timeout_(timeout) {}

  void addImage(const sensor_msgs::ImageConstPtr& image, double now);
  void addMask(const sensor_msgs::ImageConstPtr& mask);
  /// Takes the newest complete image, if there is one.
  std::optional<Match> take(double now);

  /// Answer to the question for an image near a given stamp.
  struct Near {
    std::optional<Match> match;   ///< the nearest image within the window, complete
    bool waits_for_mask = false;  ///< the image has come, its mask may still come
    bool may_come = false;        ///< no image has come, but one is due by that stamp
    double newest = 0;            ///< stamp of the newest image, s; 0: none
  };
  /// Takes the image nearest to a stamp, within `window` seconds. Newer images go on waiting.
  Near takeNear(const ros::Time& stamp, double window, double now);
  /// Number of images that were dropped for newer ones.
  size_t dropped() const { return dropped_; }

 private:
  struct Waiting {
    sensor_msgs::ImageConstPtr image;
    double since;
  };
  /// Image k with its mask; nothing while the image waits for its mask.
  std::optional<Match> complete(size_t k, double now) const;
  /// Drops image k, older images, and masks up to that of image k.
  void forgetUpTo(size_t k);

  bool use_masks_;
  double timeout_;
  std::deque<Waiting> images_;                    // in order of arrival
  std::deque<sensor_msgs::ImageConstPtr> masks_;  // in order of arrival
  double newest_ = 0;                             // stamp of an image, s
  double period_ = 0;                             // between images, s; 0: not known yet
  size_t dropped_ = 0;
};

}  // namespace edge_mcl
