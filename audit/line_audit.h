/// Adds up what many images show of the model's lines, and judges which of them exist.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/audit/line_sights.h"
#include "edge_mcl/core/edges/audit_table.h"

namespace edge_mcl {

/// The evidence for each piece of a line, by the places from which it was seen.
class LineAudit {
 public:
  /// Both must outlive this object.
  LineAudit(const LocalizationMap& map, const LineSights& sights);

  /// Adds an image. Images from about one place see the same, so they count together as one.
  void add(const std::vector<LineSight>& sights, const Eigen::Vector3d& camera_position);

  /// Judges all pieces and shapes. See docs/decisions/audit-evidence.md.
  /// @return one row for every piece of a line with the same verdict, and one for every shape that
  ///   is gone.
  std::vector<AuditRow> judge() const;

  /// Pieces that were seen well, and the share of existing lines that images never show, as learnt
  /// from shapes that exist.
  size_t seenPieces() const;
  double neverShown() const { return neverShown(evidence()); }

 private:
  struct Viewpoint {
    Eigen::Vector3f position;
    LineSight sums;
  };
  /// Of one piece of a line, natural logarithms of P(data | exists) / P(data | gone).
  struct Evidence {
    int viewpoints = 0;
    double of_images = 0, of_depth = 0;
    double shown = 0, by_chance = 0;  // means over the viewpoints
  };
  std::vector<Evidence> evidence() const;
  Evidence evidenceOf(const std::vector<Viewpoint>& seen) const;
  double neverShown(const std::vector<Evidence>& evidence) const;
  std::vector<double> oddsOfShapes(const std::vector<Evidence>& evidence, double silent) const;

  const LocalizationMap& map_;
  const LineSights& sights_;
  std::vector<std::vector<Viewpoint>> seen_;  // of every segment
};

/// Whether the images confirm at least half of the length that they saw well. Otherwise the poses
/// are wrong, or the model is that of another building, and the rows would condemn it.
bool fitsImages(const std::vector<AuditRow>& rows);

}  // namespace edge_mcl
