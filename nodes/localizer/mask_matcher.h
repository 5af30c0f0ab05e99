/// Brings every image together with its mask, or decides that none will come.
#pragma once

#include <sensor_msgs/Image.h>

#include <deque>
#include <optional>

namespace edge_mcl {

/// The newest image that is complete wins; older ones are dropped. With masks an image is complete
/// when the mask of the same stamp is there, or when it has waited for `timeout`. Not thread-safe.
class MaskMatcher {
 public:
  struct Match {
    sensor_msgs::ImageConstPtr image;
    sensor_msgs::ImageConstPtr mask;  ///< null: none came in time, or none is wanted
  };

  /// @param timeout s, by the clock of `now` below.
  MaskMatcher(bool use_masks, double timeout) : use_masks_(use_masks), timeout_(timeout) {}

  void addImage(const sensor_msgs::ImageConstPtr& image, double now);
  void addMask(const sensor_msgs::ImageConstPtr& mask);
  /// The newest complete image, if there is one.
  std::optional<Match> take(double now);

  /// What there is for a moment that another camera's image says.
  struct Near {
    std::optional<Match> match;   ///< the nearest image within the window, complete
    bool waits_for_mask = false;  ///< it is there, but its mask may still come
    bool may_come = false;        ///< none is there yet, but one is due by then
    double newest = 0;            ///< stamp of the newest image that came, s; 0: none
  };
  /// Takes the image nearest to a stamp, within `window` seconds; newer ones go on waiting for
  /// their own moments.
  Near takeNear(const ros::Time& stamp, double window, double now);
  /// Images that newer ones overtook.
  size_t dropped() const { return dropped_; }
  /// The newest mask that came, matched or not.
  const sensor_msgs::ImageConstPtr& lastMask() const { return last_mask_; }

 private:
  struct Waiting {
    sensor_msgs::ImageConstPtr image;
    double since;
  };
  /// Image k with its mask; nothing while it waits for one.
  std::optional<Match> complete(size_t k, double now) const;
  /// Forgets image k, those before it, and masks up to its own.
  void forgetUpTo(size_t k);

  bool use_masks_;
  double timeout_;
  std::deque<Waiting> images_;                    // in order of arrival
  std::deque<sensor_msgs::ImageConstPtr> masks_;  // likewise
  sensor_msgs::ImageConstPtr last_mask_;
  double newest_ = 0;  // stamp of an image, s
  double period_ = 0;  // between images, s; 0: not known yet
  size_t dropped_ = 0;
};

}  // namespace edge_mcl
