#include "edge_mcl/audit/line_audit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace edge_mcl {

namespace {

/// Places nearer to each other see the same, m.
constexpr double kSamePlace = 0.3;
/// More places tell nothing new.
constexpr size_t kMostPlaces = 24;
/// Samples and places from which a piece of a line is seen well.
constexpr float kLeastSamples = 3;
constexpr int kLeastPlaces = 3;
/// Share of the samples of an existing line that an image shows, where it shows the line.
constexpr double kShown = 0.8;
/// Share that is shown by chance where no probe is possible, and its limits.
constexpr double kUsualChance = 0.15, kLeastChance = 0.05, kMostChance = 0.6;
/// Depth: log-odds of a place where all depth is behind the surface, or on it. The pose may be
/// wrong, so one place is no proof.
constexpr double kBehind = -2, kOnSurface = 1.5;
/// One line of the model in fifty does not exist, before any image is seen.
constexpr double kGoneBefore = 0.02;
/// Lines of one shape are shown or not by the same light, so that each counts less.
constexpr double kOfOneShape = 0.6;
/// Limits of the evidence of one line.
constexpr double kMostAgainst = -8, kMostFor = 8;
constexpr double kGone = 0.1, kConfirmed = 0.9;

double probabilityOf(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

/// Evidence of a line that images may never show although it exists.
double withSilence(double evidence, double silent) {
  return std::log((1 - silent) * std::exp(std::clamp(evidence, kMostAgainst, kMostFor)) + silent);
}

const double kBefore = std::log((1 - kGoneBefore) / kGoneBefore);

void append(const LineSight& one, LineSight* sum) {
  sum->samples += one.samples;
  sum->shown += one.shown;
  sum->probes += one.probes;
  sum->by_chance += one.by_chance;
  sum->on_surface += one.on_surface;
  sum->behind += one.behind;
}

}  // namespace

LineAudit::LineAudit(const LocalizationMap& map, const LineSights& sights)
    : map_(map), sights_(sights), seen_(map.edges().segments.size()) {}

void LineAudit::add(const std::vector<LineSight>& sights, const Eigen::Vector3d& camera_position) {
  const Eigen::Vector3f at = camera_position.cast<float>();
  for (const LineSight& sight : sights) {
    std::vector<Viewpoint>& seen = seen_[sight.segment];
    const auto same = std::find_if(seen.begin(), seen.end(), [&](const Viewpoint& v) {
      return (v.position - at).norm() < static_cast<float>(kSamePlace);
    });
    if (same != seen.end())
      append(sight, &same->sums);
    else if (seen.size() < kMostPlaces)
      seen.push_back({at, sight});
  }
}

LineAudit::Evidence LineAudit::evidenceOf(const std::vector<Viewpoint>& seen) const {
  Evidence sum;
  for (const Viewpoint& v : seen) {
    const LineSight& s = v.sums;
    const auto depths = static_cast<double>(s.behind + s.on_surface);
    if (depths >= kLeastSamples) {
      const double behind = static_cast<double>(s.behind) / depths;
      sum.of_depth += behind * kBehind + (1 - behind) * kOnSurface;
    }
    if (s.samples < kLeastSamples) continue;
    const auto shown = static_cast<double>(s.shown / s.samples);
    // Two probes that find what is usual steady the share where there are few.
    const double chance = std::clamp(
        (static_cast<double>(s.by_chance) + 2 * kUsualChance) / (static_cast<double>(s.probes) + 2),
        kLeastChance, kMostChance);
    sum.of_images +=
        shown * std::log(kShown / chance) + (1 - shown) * std::log((1 - kShown) / (1 - chance));
    ++sum.viewpoints;
    sum.shown += shown;
    sum.by_chance += chance;
  }
  if (sum.viewpoints > 0) {
    sum.shown /= sum.viewpoints;
    sum.by_chance /= sum.viewpoints;
  }
  return sum;
}

std::vector<LineAudit::Evidence> LineAudit::evidence() const {
  std::vector<Evidence> list(seen_.size());
  for (size_t i = 0; i < seen_.size(); ++i) list[i] = evidenceOf(seen_[i]);
  return list;
}

size_t LineAudit::seenPieces() const {
  const std::vector<Evidence> list = evidence();
  return static_cast<size_t>(std::count_if(
      list.begin(), list.end(), [](const Evidence& e) { return e.viewpoints >= kLeastPlaces; }));
}

double LineAudit::neverShown(const std::vector<Evidence>& evidence) const {
  // Of shapes with a line that images show clearly. They exist, so their other lines do as well.
  constexpr double kClearly = 3;
  constexpr double kLeast = 0.02, kMost = 0.4;
  std::vector<bool> exists(sights_.shapes().count(), false);
  for (size_t i = 0; i < evidence.size(); ++i)
    if (sights_.shapeOf(i) >= 0 && evidence[i].of_images > kClearly)
      exists[sights_.shapeOf(i)] = true;
  double seen = 1, silent = kLeast;
  for (size_t i = 0; i < evidence.size(); ++i) {
    const int shape = sights_.shapeOf(i);
    if (shape < 0 || !exists[shape] || evidence[i].viewpoints < kLeastPlaces) continue;
    ++seen;
    if (evidence[i].of_images < -kClearly) ++silent;
  }
  return std::clamp(silent / seen, kLeast, kMost);
}

std::vector<double> LineAudit::oddsOfShapes(const std::vector<Evidence>& evidence,
                                            double silent) const {
  std::map<std::pair<int, uint32_t>, Evidence> lines;  // by shape and line
  for (size_t i = 0; i < evidence.size(); ++i) {
    const int shape = sights_.shapeOf(i);
    if (shape < 0) continue;
    Evidence& line = lines[{shape, map_.edges().segments[i].line}];
    line.viewpoints = std::max(line.viewpoints, evidence[i].viewpoints);
    line.of_images += evidence[i].of_images;
    line.of_depth += evidence[i].of_depth;
  }
  std::vector<double> odds(sights_.shapes().count(), kBefore);
  for (const auto& [key, line] : lines) {
    odds[key.first] += kOfOneShape * std::clamp(line.of_depth, kMostAgainst, kMostFor);
    if (line.viewpoints >= kLeastPlaces)
      odds[key.first] += kOfOneShape * withSilence(line.of_images, silent);
  }
  return odds;
}

std::vector<AuditRow> LineAudit::judge() const {
  const std::vector<Evidence> list = evidence();
  const double silent = neverShown(list);
  const std::vector<double> shapes = oddsOfShapes(list, silent);
  const EdgeModel& edges = map_.edges();
  const Eigen::Vector3d& origin = map_.mesh().origin;
  std::vector<AuditRow> rows;
  for (size_t k = 0; k < shapes.size(); ++k) {
    if (probabilityOf(shapes[k]) >= kGone) continue;
    AuditRow row;
    row.part = AuditRow::Part::kShape;
    row.start = sights_.shapes().box[k].min().cast<double>() + origin;
    row.end = sights_.shapes().box[k].max().cast<double>() + origin;
    row.shape = static_cast<int>(k);
    row.confidence = probabilityOf(shapes[k]);
    row.verdict = "gone";
    rows.push_back(row);
  }
  uint32_t last = 0;
  for (uint32_t i = 0; i < list.size(); ++i) {
    const EdgeSegment& segment = edges.segments[i];
    const EdgeLine& line = edges.lines[segment.line];
    if (line.kind == EdgeKind::kContour) continue;  // an outline belongs to its shape
    const Evidence& e = list[i];
    AuditRow row;
    const double half = static_cast<double>(segment.radius) + edges.sample_step / 2;
    const Eigen::Vector3d way = half * line.tangent().cast<double>();
    row.start = segment.centre.cast<double>() - way + origin;
    row.end = segment.centre.cast<double>() + way + origin;
    row.shape = sights_.shapeOf(i);
    row.viewpoints = e.viewpoints;
    row.shown = e.shown;
    row.by_chance = e.by_chance;
    double odds = kBefore + std::clamp(e.of_depth, kMostAgainst, kMostFor);
    if (e.viewpoints >= kLeastPlaces) odds += withSilence(e.of_images, silent);
    row.confidence = probabilityOf(odds);
    if (row.shape >= 0 && probabilityOf(shapes[row.shape]) < kGone)
      row.confidence = std::min(row.confidence, probabilityOf(shapes[row.shape]));
    // Where images seldom show lines that exist, a line that they never show keeps its confidence.
    const bool is_shown = e.of_images + e.of_depth > 0;
    row.verdict = row.confidence < kGone                     ? "gone"
                  : e.viewpoints < kLeastPlaces              ? "unseen"
                  : row.confidence >= kConfirmed && is_shown ? "confirmed"
                                                             : "doubtful";
    // Neighbouring pieces with the same verdict are one row.
    const bool goes_on = i > 0 && !rows.empty() && rows.back().part == AuditRow::Part::kLine &&
                         last == segment.line && rows.back().verdict == row.verdict &&
                         rows.back().shape == row.shape;
    last = segment.line;
    if (!goes_on) {
      rows.push_back(row);
      continue;
    }
    AuditRow& joined = rows.back();
    joined.end = row.end;
    joined.viewpoints = std::max(joined.viewpoints, row.viewpoints);
    joined.shown = std::max(joined.shown, row.shown);
    joined.by_chance = std::max(joined.by_chance, row.by_chance);
    joined.confidence = std::min(joined.confidence, row.confidence);
  }
  return rows;
}

bool fitsImages(const std::vector<AuditRow>& rows) {
  constexpr double kLeastShare = 0.5;
  constexpr double kEnough = 1;  // m; less was seen by chance
  double confirmed = 0, seen = 0;
  for (const AuditRow& row : rows) {
    if (row.part != AuditRow::Part::kLine || row.verdict == "unseen") continue;
    const double length = (row.end - row.start).norm();
    seen += length;
    if (row.verdict == "confirmed") confirmed += length;
  }
  return seen < kEnough || confirmed >= kLeastShare * seen;
}

}  // namespace edge_mcl
