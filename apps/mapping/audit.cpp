// edge-mcl audit: tells which parts of a model the images of a recording confirm, which parts are
// gone, and which lines are new.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/common_options.h"
#include "apps/mapping/mapping_source.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "apps/recordings/recording_options.h"
#include "edge_mcl/audit/audit_drawing.h"
#include "edge_mcl/audit/line_audit.h"
#include "edge_mcl/audit/new_lines.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"

namespace edge_mcl {

namespace {

struct AuditOptions : RecordingOptions {
  std::string out = "audit.csv", picture, obj, poses;
  bool json = false;
};

/// Collects the evidence, image by image.
class Auditor {
 public:
  explicit Auditor(std::shared_ptr<const LocalizationMap> map)
      : map_(std::move(map)), sights_(*map_), audit_(*map_, sights_) {}

  /// @param image of the first camera. @param T_map_base a pose that is trusted
  void add(const LiveInput& input, const PreparedImage& image, const Pose& T_map_base) {
    const Pose T_map_camera = T_map_base * input.images.front().T_base_camera;
    if (!gate_.take(T_map_camera)) return;
    std::optional<MappingImage> mapped = mappingImageOf(input, T_map_base);
    audit_.add(sights_.find(image, mapped ? mapped->depth : cv::Mat(), T_map_camera),
               T_map_camera.translation());
    ++images_;
    if (!mapped) return;
    ++depths_;
    mapped->number = static_cast<uint32_t>(images_);
    focal_ = input.images.front().camera.fx;
    const std::vector<DepthSegment> found =
        findDepthSegments(*mapped, CameraRays(input.images.front().camera), {});
    segments_.insert(segments_.end(), found.begin(), found.end());
  }

  size_t images() const { return images_; }
  size_t depths() const { return depths_; }
  const LineAudit& audit() const { return audit_; }
  std::vector<AuditRow> rows() const {
    std::vector<AuditRow> rows = audit_.judge();
    TrackOptions tracking;
    tracking.focal = focal_;
    const std::vector<AuditRow> found = findNewLines(trackLines(segments_, tracking), *map_);
    rows.insert(rows.end(), found.begin(), found.end());
    return rows;
  }

 private:
  std::shared_ptr<const LocalizationMap> map_;
  LineSights sights_;
  LineAudit audit_;
  MotionGate gate_;
  std::vector<DepthSegment> segments_;
  double focal_ = 525;
  size_t images_ = 0, depths_ = 0;
};

/// Takes the poses of a trajectory.
void addGivenPoses(const AuditOptions& o, OpenedRecording* opened, Auditor* auditor) {
  const Trajectory poses = readTrajectory(o.poses);
  ProgressBar bar(opened->name, opened->input->imageCount());
  LiveInput input;
  for (std::string problem; opened->input->next(&input, &problem); input = {}) {
    bar.advance();
    std::optional<Pose> pose = poseAt(poses, input.time);
    if (!pose || input.images.empty()) continue;
    pose->translation() -= opened->origin;
    const LiveInput::CameraImage& view = input.images.front();
    try {
      auditor->add(input, *opened->map->prepare(view.camera, view.image, view.mask, view.origin),
                   *pose);
    } catch (const InputError& e) {
      bar.note(std::string("warning: ") + e.what());
    }
  }
}

/// Takes the poses that the localizer finds, while it trusts them.
void addFoundPoses(OpenedRecording* opened, Auditor* auditor) {
  RecordedLocalizer localizer(opened->map, std::move(opened->input), opened->start);
  ProgressBar bar(opened->name, localizer.recording().imageCount());
  while (localizer.next()) {
    bar.advance();
    const LiveResult& r = localizer.result();
    if (r.state != LocalizerState::kTracking || r.images.empty() || r.image_numbers.front() != 0)
      continue;
    auditor->add(localizer.input(), *r.images.front(), r.estimate.mean);
  }
}

nlohmann::json summaryOf(const Auditor& auditor, const std::vector<AuditRow>& rows) {
  nlohmann::json j = {{"images", auditor.images()},
                      {"images_with_depth", auditor.depths()},
                      {"pieces_seen_well", auditor.audit().seenPieces()},
                      {"share_never_shown", auditor.audit().neverShown()},
                      {"gone_shapes", nlohmann::json::array()},
                      {"new_objects", nlohmann::json::array()}};
  for (const auto& [verdict, length] : lengthsOf(rows)) j["length_m"][verdict] = length;
  const auto corners = [](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    return nlohmann::json{{"lowest", {low.x(), low.y(), low.z()}},
                          {"highest", {high.x(), high.y(), high.z()}}};
  };
  for (const AuditRow& row : rows) {
    if (row.part != AuditRow::Part::kShape) continue;
    nlohmann::json shape = corners(row.start, row.end);
    shape["confidence"] = row.confidence;
    j["gone_shapes"].push_back(shape);
  }
  for (const NewObject& object : newObjects(rows)) {
    nlohmann::json box = corners(object.lowest, object.highest);
    box["lines"] = object.lines;
    j["new_objects"].push_back(box);
  }
  return j;
}

void print(const nlohmann::json& summary) {
  const auto box = [](const nlohmann::json& j) {
    std::string text;
    for (const char* corner : {"lowest", "highest"}) {
      char part[96];
      std::snprintf(part, sizeof part, "%s(%.2f, %.2f, %.2f)", text.empty() ? "" : " to ",
                    j[corner][0].get<double>(), j[corner][1].get<double>(),
                    j[corner][2].get<double>());
      text += part;
    }
    return text;
  };
  std::printf("images          %zu, of these %zu with depth\n", summary["images"].get<size_t>(),
              summary["images_with_depth"].get<size_t>());
  for (const auto& [verdict, length] : summary["length_m"].items())
    std::printf("  %-13s %.1f m\n", verdict.c_str(), length.get<double>());
  for (const auto& shape : summary["gone_shapes"])
    std::printf("  gone          a shape at %s\n", box(shape).c_str());
  for (const auto& object : summary["new_objects"])
    std::printf("  new           an object at %s, %zu lines\n", box(object).c_str(),
                object["lines"].get<size_t>());
}

int run(const AuditOptions& o) {
  for (const std::string& file : {o.out, o.obj}) checkOutput(file);
  checkPicture(o.picture);
  RecordingOptions options = o;
  if (!o.poses.empty()) options.global = true;  // needs no initial pose
  OpenedRecording opened = openRecording(options, true);
  Auditor auditor(opened.map);
  if (o.poses.empty())
    addFoundPoses(&opened, &auditor);
  else
    addGivenPoses(o, &opened, &auditor);
  if (auditor.images() == 0)
    throw InputError(o.recording + (o.poses.empty()
                                        ? ": no image was localized, so nothing can be said about "
                                          "the model"
                                        : ": no image has a pose in " + o.poses));
  const std::vector<AuditRow> rows = auditor.rows();
  if (!fitsImages(rows))
    throw InputError(o.recording +
                     ": the images confirm less than half of the lines that they saw "
                     "well, so " +
                     (o.poses.empty() ? "the model is that of another building"
                                      : "the poses of " + o.poses + " do not fit the model") +
                     "; no table is written");
  writeAuditTable(o.out, rows);
  if (!o.obj.empty()) writeAuditObj(o.obj, rows);
  if (!o.picture.empty()) writePicture(o.picture, drawAudit(rows, {1000, 800}));
  const nlohmann::json summary = summaryOf(auditor, rows);
  if (o.json) {
    std::printf("%s\n", textOf(summary).c_str());
    return kExitOk;
  }
  print(summary);
  if (auditor.depths() == 0)
    std::printf("  the recording has no depth, so new lines are not looked for\n");
  std::printf("table: %s; `--set map.confidence=%s` leaves out what is gone\n", o.out.c_str(),
              o.out.c_str());
  return kExitOk;
}

}  // namespace

void addAudit(CLI::App* app, Action* action) {
  auto o = std::make_shared<AuditOptions>();
  CLI::App* c = app->add_subcommand(
      "audit", "tell which parts of a model a recording confirms, which are gone, and what is new");
  o->addTo(c);
  c->add_option("--poses", o->poses,
                "trajectory (TUM format) with poses to trust: T_map_camera for a directory, else "
                "T_map_base; default: the recording is localized, and images called `tracking` "
                "count");
  c->add_option("--out", o->out, "table to write (CSV, for map.confidence); default: audit.csv");
  c->add_option("--picture", o->picture, "file for a picture of the lines by verdict");
  c->add_option("--obj", o->obj, "OBJ file with the lines, one object for each verdict");
  c->add_flag("--json", o->json, "print the summary as JSON; default: as text");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
