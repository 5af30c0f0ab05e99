/// Follows the objects that a depth camera sees in front of the model: people, furniture, boxes.
///
/// The paper wants an object, once it is found, to be identified quickly in all further images.
/// Here an object needs no name: it is what the model does not explain.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/mesh/ray_mesh.h"
#include "edge_mcl/localization/objects/object_view.h"

namespace edge_mcl {

/// An object that is not in the model. Map frame.
struct ObjectState {
  int number = 0;                                      ///< stays the same while it is known
  Eigen::AlignedBox3d box;                             ///< in the axes of the map, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s; zero while it stands still
  /// Standard deviation of the middle of the box, per axis, without that of the camera's pose, m.
  /// It grows while an object that has moved is out of view.
  double position_sigma = 0;
  bool is_moving = false;                ///< it moves, or did so when it was last seen
  bool is_in_view = false;               ///< the newest depth images show it
  double first_seen = 0, last_seen = 0;  ///< s
  double still_since = 0;                ///< s; without a meaning while it moves
};

/// Gives the objects numbers, boxes and velocities.
///
/// The foreign points of every depth image are grouped (clustersOf()). A group continues the object
/// whose box it touches. An object stands still while the places of its surface a moment before
/// are still surface. Its box then collects all that was seen of it, and places that an
/// image sees through are taken out. The box of an object that moves is that of the newest image,
/// completed by the size that earlier ones have shown. Its middle is followed by a Kalman filter
/// with constant velocity.
///
/// Objects out of view stay where they are. One whose place is seen to be empty is kept for a
/// minute without a place. A new group takes the number of an object out of view when it is as
/// large, looks alike, and can be there by now. Not thread-safe.
class ObjectFollower {
 public:
  /// @param time s, later than the last one @param depths,colours at trusted poses
  /// @param scene faces of the model, for floors; may be null
  void update(double time, const std::vector<ForeignDepth>& depths,
              const std::vector<ForeignColour>& colours, const RayScene* scene,
              const DepthParameters& params);
  /// Objects that were seen at least three times, in the order of their numbers. Those without a
  /// place are left out. @param time now, s
  std::vector<ObjectState> objects(double time) const;
  /// Forgets all objects. Numbers are not used again.
  void forget();

 private:
  struct Place {
    Eigen::Vector3f point;
    int seen = 0;  // images
  };
  /// Points of an object in one image.
  struct Surface {
    double time;
    PointCluster points;
  };
  struct Track {
    ObjectState object;
    int sightings = 0;
    int torn = 0;  // images in a row in which it was two groups that lie apart
    bool has_moved = false;
    bool is_gone = false;        // its place was seen to be empty
    int empty = 0;               // images in a row that saw its place empty
    Eigen::AlignedBox3d newest;  // of its points in the newest image, moved to now
    std::optional<SeenSize> size;
    Appearance appearance;
    // Kalman filter: middle and velocity, with the same variances for all axes.
    Eigen::Vector3d middle, velocity = Eigen::Vector3d::Zero();
    Eigen::Matrix2d variance;
    double filtered_at = 0;           // s
    std::map<int64_t, Place> places;  // seen while it stood still
    std::deque<Surface> surfaces;     // of the last second
    double kept_share = 1;            // of the surface a moment before, smoothed
    bool is_judged = false;           // it has been compared with such a surface
  };

  /// Whether a group may simply continue a track: it was in view a moment ago.
  static bool isFollowed(const Track& track, double time);
  static void predict(Track* track, double time);
  void see(double time, const ForeignDepth& view, const std::vector<ForeignColour>& colours,
           const RayScene* scene, const DepthParameters& params);
  /// Groups that continue tracks which were in view a moment ago. @param clusters those that
  /// continue none are left @param apart those that were taken for parts of an object, and are not
  std::map<size_t, PointCluster> continued(double time, std::vector<PointCluster>* clusters,
                                           std::vector<PointCluster>* apart);
  /// The track that stood where a group is. @return number of tracks when there is none
  size_t standingAt(const PointCluster& cluster) const;
  /// The track out of view that a new track goes on. @return number of tracks when there is none
  size_t knownAgain(double time, const Track& found) const;
  /// A track that begins with what one image shows.
  static Track begun(double time, const ObjectSide& side);
  /// Numbers new tracks that have been seen often enough.
  void giveNumbers(double time);
  void add(double time, const PointCluster& cluster, const ForeignDepth& view,
           const std::vector<ForeignColour>& colours, const RayScene* scene,
           const DepthParameters& params, Track* track);
  static void filterMiddle(const Eigen::Vector3d& measured, Track* track);
  static void judgeMotion(double time, const PointCluster& cluster, const ForeignDepth& view,
                          const DepthParameters& params, Track* track);
  static void collect(const PointCluster& cluster, const ForeignDepth& view,
                      const DepthParameters& params, Track* track);
  /// Notes objects that were not found, although their place is in view.
  void noteEmptyPlaces(double time, const std::vector<ForeignDepth>& depths,
                       const DepthParameters& params);
  void forgetOld(double time);

  /// Speed of people, m/s, and the time after which an object without a place, or that has moved,
  /// is forgotten out of view, s.
  static constexpr double kWalking = 1.5, kRemember = 60;

  std::vector<Track> tracks_;
  int next_number_ = 1;
};

}  // namespace edge_mcl
