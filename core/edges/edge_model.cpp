#include "edge_mcl/core/edges/edge_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/edges/covered_edges.h"
#include "edge_mcl/core/edges/line_cuts.h"
#include "edge_mcl/core/edges/line_merging.h"

namespace edge_mcl {

const char* edgeKindName(EdgeKind kind) {
  constexpr const char* kNames[] = {"crease", "boundary", "material", "line", "contour"};
  return kNames[static_cast<int>(kind)];
}

uint16_t usedSamples(const EdgeSegment& segment, uint32_t thinning) {
  const uint32_t past = segment.first_sample % thinning;
  uint32_t mask = 0;
  for (uint32_t i = past == 0 ? 0 : thinning - past; i < segment.sample_count; i += thinning)
    mask |= 1u << i;
  return static_cast<uint16_t>(mask);
}

size_t EdgeModel::countOf(EdgeKind kind) const {
  return static_cast<size_t>(
      std::count_if(lines.begin(), lines.end(), [&](const EdgeLine& l) { return l.kind == kind; }));
}

namespace {

/// One side of a triangle, keyed by its sorted vertices.
struct HalfEdge {
  uint32_t low, high;
  uint32_t triangle;
  bool forward;  // runs from low to high
};

/// Faces that one smooth surface connects.
class Patches {
 public:
  explicit Patches(size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), uint32_t{0});
  }
  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(uint32_t a, uint32_t b) { parent_[find(b)] = find(a); }

 private:
  std::vector<uint32_t> parent_;
};

std::vector<HalfEdge> sortedHalfEdges(const MeshModel& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!mesh.hides_only.empty() && mesh.hides_only[t]) continue;
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return edges;
}

Eigen::Vector3f triangleNormal(const MeshModel& mesh, uint32_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
  return (mesh.vertices[t[1]].cast<double>() - a)
      .cross(mesh.vertices[t[2]].cast<double>() - a)
      .normalized()
      .cast<float>();
}

/// Unit vector in the plane of the triangle, perpendicular to the line, away from it.
Eigen::Vector3f intoFace(const MeshModel& mesh, uint32_t triangle, const EdgeLine& line) {
  const auto& t = mesh.triangles[triangle];
  const Eigen::Vector3d tangent = (line.end - line.start).cast<double>().normalized();
  Eigen::Vector3d into = Eigen::Vector3d::Zero();
  for (uint32_t corner : t) {
    const Eigen::Vector3d d = (mesh.vertices[corner] - line.start).cast<double>();
    const Eigen::Vector3d across = d - tangent * tangent.dot(d);
    if (across.norm() > into.norm()) into = across;
  }
  return into.normalized().cast<float>();
}

struct FoundEdges {
  std::vector<EdgeLine> features;
  std::vector<bool> is_shared;             // of every feature: whether it has three or more faces
  std::vector<EdgeLine> contours;          // candidates
  std::vector<uint32_t> contour_triangle;  // one adjacent triangle each
};

/// The half edges [begin, end) of one edge.
struct EdgeRange {
  const HalfEdge *begin, *end;
};

/// Finds the two faces of an edge that meet most sharply and writes them to `line`.
/// @param materials_differ set when two faces have different materials
/// @return cosine of the angle between their normals
double sharpestPair(const EdgeRange& range, MeshModel* mesh, EdgeLine* line,
                    bool* materials_differ) {
  // Each face is compared with at most seven others. An edge of a sound mesh has two to four faces.
  // A broken mesh may have thousands, and all their pairs would take the square of that.
  constexpr long kCompared = 8;
  double least_cos = 2;
  for (const HalfEdge* a = range.begin; a < range.end; ++a)
    for (const HalfEdge* b = a + 1; b < std::min(range.end, a + kCompared); ++b) {
      const Eigen::Vector3f normal_a = triangleNormal(*mesh, a->triangle);
      Eigen::Vector3f normal_b = triangleNormal(*mesh, b->triangle);
      if (a->forward == b->forward) {
        normal_b = -normal_b;  // the two faces are wound in opposite directions
        if (range.end - range.begin == 2) ++mesh->report.flipped_pairs;
      }
      const double c = normal_a.dot(normal_b);
      *materials_differ = *materials_differ || mesh->triangle_material[a->triangle] !=
                                                   mesh->triangle_material[b->triangle];
      if (c >= least_cos) continue;
      least_cos = c;
      line->normal_a = normal_a;
      line->normal_b = normal_b;
      line->into_a = intoFace(*mesh, a->triangle, *line);
      line->into_b = intoFace(*mesh, b->triangle, *line);
    }
  return least_cos;
}

FoundEdges classifyEdges(MeshModel* mesh, const MapParameters& params, Patches* patches) {
  constexpr double kFlatDegrees = 0.05;  // faces within this are one plane up to rounding
  const double crease_cos = std::cos(params.crease_angle_deg * kDegree);
  const double flat_cos = std::cos(kFlatDegrees * kDegree);
  FoundEdges found;
  const std::vector<HalfEdge> edges = sortedHalfEdges(*mesh);
  for (size_t i = 0; i < edges.size();) {
    size_t j = i;
    while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
    EdgeLine line;
    line.start = mesh->vertices[edges[i].low];
    line.end = mesh->vertices[edges[i].high];
    const size_t faces = j - i;
    if (faces == 1) {
      ++mesh->report.boundary_edges;
      line.kind = EdgeKind::kBoundary;
      line.into_a = intoFace(*mesh, edges[i].triangle, line);
      if (params.boundaries) found.features.push_back(line);
    } else {
      if (faces > 2) ++mesh->report.non_manifold_edges;
      bool materials_differ = false;
      const double least_cos =
          sharpestPair({edges.data() + i, edges.data() + j}, mesh, &line, &materials_differ);
      const bool crease = least_cos <= crease_cos;
      if (!crease) patches->join(edges[i].triangle, edges[i + 1].triangle);
      if (crease) {
        line.kind = EdgeKind::kCrease;
        found.features.push_back(line);
      } else if (materials_differ && params.material_borders) {
        line.kind = EdgeKind::kMaterial;
        found.features.push_back(line);
      } else if (least_cos < flat_cos && params.contours) {
        line.kind = EdgeKind::kContour;
        found.contours.push_back(line);
        found.contour_triangle.push_back(edges[i].triangle);
      }
    }
    found.is_shared.resize(found.features.size(), faces > 2);
    i = j;
  }
  return found;
}

double automaticStep(double feature_length, double diagonal) {
  constexpr double kWantedSamples = 4000;
  return std::clamp(std::max(feature_length / kWantedSamples, diagonal / 100), 1e-4, 0.05);
}

void sampleLines(EdgeModel* model) {
  for (uint32_t l = 0; l < model->lines.size(); ++l) {
    const EdgeLine& line = model->lines[l];
    const double length = line.length();
    const auto count =
        static_cast<uint32_t>(std::max(1.0, std::round(length / model->sample_step)));
    const double step = length / count;
    const auto at = [&](double sample) { return (sample + 0.5) * step; };  // from the start
    for (uint32_t first = 0; first < count; first += EdgeSegment::kMaxSamples) {
      EdgeSegment segment;
      segment.line = l;
      segment.first_sample = static_cast<uint32_t>(model->sample_along.size());
      segment.sample_count = std::min(EdgeSegment::kMaxSamples, count - first);
      const double middle = at(first + (segment.sample_count - 1) / 2.0);
      segment.centre = line.start + static_cast<float>(middle) * line.tangent();
      segment.radius =
          static_cast<float>(0.5 * (segment.sample_count - 1) * step) * 1.0001f + 1e-5f;
      for (uint32_t s = 0; s < segment.sample_count; ++s)
        model->sample_along.push_back(static_cast<float>(at(first + s) - middle));
      model->segments.push_back(segment);
    }
  }
}

/// Short pieces of one smooth surface form one group. A long straight piece is a line by itself.
void appendContours(FoundEdges found, Patches* patches, EdgeModel* model) {
  const double long_enough = 3 * model->sample_step;
  std::vector<uint32_t> order(found.contours.size());
  std::iota(order.begin(), order.end(), uint32_t{0});
  std::vector<uint32_t> patch(found.contours.size());
  for (uint32_t i = 0; i < order.size(); ++i) patch[i] = patches->find(found.contour_triangle[i]);
  const auto isLong = [&](uint32_t i) { return found.contours[i].length() >= long_enough; };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    if (isLong(a) != isLong(b)) return isLong(a);
    if (!isLong(a) && patch[a] != patch[b]) return patch[a] < patch[b];
    return a < b;
  });
  for (size_t k = 0; k < order.size(); ++k) {
    const uint32_t i = order[k];
    const bool same_patch =
        k > 0 && !isLong(i) && !isLong(order[k - 1]) && patch[order[k - 1]] == patch[i];
    if (!same_patch) ++model->group_count;
    found.contours[i].group = model->group_count - 1;
    model->lines.push_back(found.contours[i]);
  }
}

}  // namespace

EdgeModel buildEdgeModel(MeshModel* mesh, const MapParameters& params) {
  EdgeModel model;
  Patches patches(mesh->triangles.size());
  FoundEdges found = classifyEdges(mesh, params, &patches);
  if (!params.seams) {
    const CoveredEdges covered =
        dropCoveredEdges(*mesh, params.material_borders, found.is_shared, &found.features);
    mesh->report.covered_edges = covered.count;
    mesh->report.covered_length = covered.length;
  }
  for (const auto& l : mesh->lines) {
    EdgeLine line;
    line.start = mesh->vertices[l[0]];
    line.end = mesh->vertices[l[1]];
    line.kind = EdgeKind::kLine;
    found.features.push_back(line);
  }
  const double tolerance = std::clamp(1e-5 * mesh->diagonal(), 1e-6, 1e-3);
  model.merged_pieces = mergeCollinear(&found.features, tolerance);
  const size_t cut = cutOut(mesh->left_out, &found.features);
  if (!mesh->left_out.empty())
    mesh->report.warnings.push_back("map.confidence leaves out " + std::to_string(cut) + " of " +
                                    std::to_string(mesh->left_out.size()) +
                                    " pieces of lines; the others are not in the map");
  for (const EdgeLine& line : found.features) {
    if (line.length() < params.min_line_length || line.length() <= 0) continue;
    model.feature_length += line.length();
    model.lines.push_back(line);
  }
  model.group_count = groupCurves(&model.lines, tolerance);
  model.sample_step = params.sample_step > 0
                          ? params.sample_step
                          : automaticStep(model.feature_length, mesh->diagonal());
  appendContours(std::move(found), &patches, &model);
  sampleLines(&model);
  return model;
}

}  // namespace edge_mcl
