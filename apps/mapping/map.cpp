// edge-mcl map: makes a map of straight lines and hiding faces from scans and recordings.
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "apps/common_options.h"
#include "apps/mapping/mapping_source.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/import/map_frame.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/mapping/cloud_surface.h"
#include "edge_mcl/mapping/depth_fusion.h"
#include "edge_mcl/mapping/face_simplification.h"
#include "edge_mcl/mapping/map_file.h"
#include "edge_mcl/mapping/scan_views.h"

namespace edge_mcl {

namespace {

struct MapOptions {
  std::vector<std::string> sources;
  std::string out = "map.obj", picture, poses, topics, camera;
  size_t min_views = 0;
  double face_size = 0.05, spacing = 0.8;
  bool no_faces = false;
  ParameterOptions parameters;
};

/// What has been found so far.
struct MapParts {
  std::vector<MappedLine> lines;
  MeshSoup faces;
  Eigen::Vector3d faces_origin = Eigen::Vector3d::Zero();  ///< in the coordinates of the lines

  /// Adds lines and, when there are none yet, faces. @param origin of both, m
  void add(std::vector<MappedLine> more, MeshSoup soup, const Eigen::Vector3d& origin) {
    for (MappedLine& line : more) {
      line.start += origin;
      line.end += origin;
      lines.push_back(line);
    }
    if (!faces.triangles.empty()) return;
    faces = std::move(soup);
    faces_origin = origin;
  }
};

/// Images are kept until there are enough for all threads.
class SegmentFinder {
 public:
  SegmentFinder(CameraRays rays, const SegmentOptions& options)
      : rays_(std::move(rays)), options_(options) {}

  void add(MappingImage image) {
    constexpr size_t kBatch = 16;  // 30 MB of images
    waiting_.push_back(std::move(image));
    if (waiting_.size() >= kBatch) flush();
  }
  const std::vector<DepthSegment>& finish() {
    flush();
    return segments_;
  }

 private:
  void flush() {
    std::vector<std::vector<DepthSegment>> found(waiting_.size());
    tbb::parallel_for(size_t{0}, waiting_.size(), [&](size_t i) {
      found[i] = findDepthSegments(waiting_[i], rays_, options_);
    });
    for (const auto& list : found) segments_.insert(segments_.end(), list.begin(), list.end());
    waiting_.clear();
  }

  CameraRays rays_;
  SegmentOptions options_;
  std::vector<MappingImage> waiting_;
  std::vector<DepthSegment> segments_;
};

bool isRecording(const std::string& source) {
  return kindOf(source) != RecordingKind::kDirectory || std::filesystem::is_directory(source);
}

void addRecording(const MapOptions& o, const std::string& source, MapParts* parts) {
  RecordingOptions options;
  options.recording = source;
  options.topics = o.topics;
  options.camera = o.camera;
  MappingRecording recording(options, o.poses);
  std::unique_ptr<SegmentFinder> finder;
  std::unique_ptr<DepthFusion> fusion;
  ProgressBar bar(source, recording.imageCount());
  while (recording.next()) {
    bar.advance();
    if (!recording.image()) continue;
    if (!finder) {
      const CameraModel& camera = *recording.camera();
      finder = std::make_unique<SegmentFinder>(CameraRays(camera), SegmentOptions());
      if (!o.no_faces && DepthFusion::isAvailable()) {
        FusionOptions fusing;
        fusing.face_size = o.face_size;
        fusion = std::make_unique<DepthFusion>(camera, fusing);
      }
    }
    finder->add(*recording.image());
    if (fusion) fusion->add(*recording.image());
  }
  if (!finder)
    throw InputError(source + ": no image has both depth and a pose, so there is nothing to map");
  TrackOptions tracking;
  tracking.focal = recording.camera()->fx;
  if (o.min_views > 0) tracking.min_views = o.min_views;
  const std::vector<MappedLine> lines = trackLines(finder->finish(), tracking);
  parts->add(lines, fusion ? fusion->faces() : MeshSoup(), recording.origin());
  std::printf("%s: %zu images, %zu lines\n", source.c_str(), recording.used(), lines.size());
}

/// The surface of a scan in the map frame.
MeshModel scanOf(const std::string& source, const MapParameters& params) {
  constexpr double kCloudSpacing = 0.02;  // m, finer than the noise of most scanners at 5 m
  if (!isPointCloud(source)) {
    MeshModel mesh = loadMesh(source, params);
    const bool is_unit_known = params.scale > 0 || !mesh.report.unit.empty();
    const std::string doubt = is_unit_known ? "" : sizeDoubt(mesh.diagonal());
    // Looking at a room of kilometres from everywhere takes hours.
    if (!doubt.empty()) throw InputError(source + ": " + doubt + ", or to 1 when it is that large");
    for (const std::string& warning : mesh.report.warnings)
      std::fprintf(stderr, "%s: note: %s\n", source.c_str(), warning.c_str());
    return mesh;
  }
  std::fprintf(stderr, "%s: a surface is put through the points\n", source.c_str());
  CloudSurface surface = surfaceOfCloud(source, params, kCloudSpacing);
  MeshModel mesh = weldMesh(std::move(surface.soup), 1e-6, source);
  mesh.origin = surface.origin;
  return mesh;
}

void addScan(const MapOptions& o, const std::string& source, const MapParameters& params,
             MapParts* parts) {
  const MeshModel mesh = scanOf(source, params);
  if (mesh.triangles.empty())
    throw InputError(source +
                     ": the scan has no faces; a point cloud is a PLY, PCD, PTS or XYZ file");
  const ScanViews views(mesh);
  ScanPlaces wanted;
  wanted.spacing = o.spacing;
  const std::vector<ScanViews::View> places = views.views(wanted);
  if (places.empty())
    throw InputError(source +
                     ": no place inside the scan sees its front sides; are its faces "
                     "inside out?");
  SegmentOptions options;
  options.needs_both_sides = true;
  options.min_extrapolation = 0;  // the depth of a rendered scan has no noise of its own
  options.max_depth = 6;
  const CameraRays rays(views.camera());
  std::vector<DepthSegment> segments;
  ProgressBar bar(source, places.size());
  // Outlines and noise at a small angle look like edges from a few places. In a noisy room of 80 m
  // of edges three places leave 27 m of other lines, and four 5 m.
  constexpr size_t kLeastPlaces = 4;
  constexpr size_t kBatch = 16;  // views between two steps of the progress bar
  for (size_t first = 0; first < places.size(); first += kBatch) {
    const size_t count = std::min(kBatch, places.size() - first);
    std::vector<std::vector<DepthSegment>> found(count);
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
      for (const MappingImage& image : views.render(places[first + i])) {
        const std::vector<DepthSegment> list = findDepthSegments(image, rays, options);
        found[i].insert(found[i].end(), list.begin(), list.end());
      }
    });
    for (const auto& list : found) {
      segments.insert(segments.end(), list.begin(), list.end());
      bar.advance();
    }
  }
  TrackOptions tracking;
  tracking.focal = views.camera().fx;
  tracking.pixel_sigma = 1;
  tracking.min_views = o.min_views > 0 ? o.min_views : kLeastPlaces;
  const std::vector<MappedLine> lines = trackLines(segments, tracking);
  parts->add(lines,
             o.no_faces ? MeshSoup() : simplifiedFaces(mesh.vertices, mesh.triangles, o.face_size),
             mesh.origin);
  std::printf("%s: %zu triangles, %u places, %zu lines\n", source.c_str(), mesh.triangles.size(),
              places.back().place + 1, lines.size());
}

int run(const MapOptions& o) {
  checkOutput(o.out);
  checkPicture(o.picture);
  const Parameters params = o.parameters.load();
  MapParts parts;
  for (const std::string& source : o.sources) {
    if (isRecording(source))
      addRecording(o, source, &parts);
    else
      addScan(o, source, params.map, &parts);
  }
  if (parts.lines.empty())
    throw InputError(o.sources.front() + ": no line was found that enough images agree on");
  writeMapFile(o.out, parts.lines, parts.faces, parts.faces_origin, "map by edge-mcl map");
  double length = 0;
  for (const MappedLine& line : parts.lines) length += (line.end - line.start).norm();
  std::printf("%s: %zu lines with a length of %.1f m, %zu hiding faces\n", o.out.c_str(),
              parts.lines.size(), length, parts.faces.triangles.size());
  if (!DepthFusion::isAvailable() && !o.no_faces && parts.faces.triangles.empty())
    std::fprintf(stderr, "warning: this build has no Open3D, so the map has no hiding faces\n");
  if (!o.picture.empty())
    writePicture(o.picture, drawWireframe(LocalizationMap(o.out, {}), 1000, 800));
  return kExitOk;
}

}  // namespace

void addMap(CLI::App* app, Action* action) {
  auto o = std::make_shared<MapOptions>();
  CLI::App* c = app->add_subcommand(
      "map", "make a map of straight lines and hiding faces from scans and recordings");
  c->add_option("source", o->sources,
                "scans (meshes: PLY, OBJ, ...; point clouds: PLY, PCD, PTS, XYZ) and recordings "
                "with depth and poses (sequence "
                "directory, bag or rawlog), all in one frame")
      ->required();
  c->add_option("--out", o->out, "map file to write (OBJ); default: map.obj");
  c->add_option("--picture", o->picture, "file for a picture of the map; default: no picture");
  c->add_option("--poses", o->poses,
                "trajectory (TUM format) with the poses of the recording's images; default: the "
                "ground truth of the recording");
  c->add_option("--topics", o->topics, "topics of a bag, as for localize");
  c->add_option("--camera", o->camera, "YAML file with the camera of a rawlog, as for localize");
  c->add_option("--min-views", o->min_views,
                "images (of a scan: places) that must agree on a line; default: 4")
      ->check(numberFrom(1, 1000));
  c->add_option("--face-size", o->face_size, "size of the hiding faces, m; default: 0.05")
      ->check(numberFrom(0.005, 5));
  c->add_option("--spacing", o->spacing,
                "distance of the places from which a scan is looked at, m; default: 0.8")
      ->check(numberFrom(0.1, 10));
  c->add_flag("--no-faces", o->no_faces, "write lines only");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
