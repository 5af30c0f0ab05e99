// edge-mcl audit: tells which parts of a model the images of a recording confirm, which parts are
// gone, and which lines are new.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "apps/common_options.h"
#include "apps/mapping/mapping_source.h"
#include "apps/mapping/standing_things.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "apps/recordings/recording_options.h"
#include "edge_mcl/audit/audit_drawing.h"
#include "edge_mcl/audit/line_audit.h"
#include "edge_mcl/audit/map_additions.h"
#include "edge_mcl/audit/new_lines.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"
#include "edge_mcl/mapping/depth_fusion.h"

namespace edge_mcl {

namespace {

struct AuditOptions : RecordingOptions {
  std::string out = "audit.csv", picture, obj, poses, add;
  double add_after = 30;  // s
  bool add_markings = false;
  bool json = false;
};

/// Names or files that are separated by commas.
std::vector<std::string> namesIn(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, ',');) {
    name.erase(0, name.find_first_not_of(' '));
    name.erase(name.find_last_not_of(' ') + 1);
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

/// Collects the evidence, image by image.
class Auditor {
 public:
  /// @param finds_things what stands where the model has nothing is found, too.
  Auditor(std::shared_ptr<const LocalizationMap> map, bool finds_things)
      : map_(std::move(map)), sights_(*map_), audit_(*map_, sights_), finds_things_(finds_things) {}

  /// @param image of the first camera. @param T_map_base a pose that is trusted
  void add(const LiveInput& input, const PreparedImage& image, const PoseGaussian& T_map_base) {
    if (finds_things_) things_.add(input, T_map_base);
    const Pose T_map_camera = T_map_base.mean * input.images.front().T_base_camera;
    if (!gate_.take(T_map_camera)) return;
    std::optional<MappingImage> mapped = mappingImageOf(input, T_map_base.mean);
    audit_.add(sights_.find(image, mapped ? mapped->depth : cv::Mat(), T_map_camera),
               T_map_camera.translation());
    ++images_;
    if (!mapped) return;
    ++depths_;
    mapped->number = static_cast<uint32_t>(images_);
    const CameraModel& camera = input.images.front().camera;
    focal_ = camera.fx;
    if (finds_things_ && DepthFusion::isAvailable()) {
      if (!fusion_) fusion_ = std::make_unique<DepthFusion>(camera, FusionOptions());
      fusion_->add(*mapped);
    }
    const std::vector<DepthSegment> found = findDepthSegments(*mapped, CameraRays(camera), {});
    segments_.insert(segments_.end(), found.begin(), found.end());
  }

  size_t images() const { return images_; }
  size_t depths() const { return depths_; }
  const LineAudit& audit() const { return audit_; }
  const StandingThings& things() const { return things_; }
  /// What a map can take of the things that stood for at least this time, s.
  MapAdditions additions(const std::vector<AuditRow>& rows, double seconds) const {
    std::vector<StandingThing> things = things_.longerThan(seconds);
    // The model may hold the things of an earlier audit.
    std::map<std::string, size_t> objects = map_->mesh().report.objects;
    // Excluded ones are not in the report, and a new thing with their number would be excluded.
    for (const std::string& name : namesIn(map_->params().map.exclude)) objects[name] = 0;
    const int first = highestThing(objects);
    for (StandingThing& thing : things) thing.number += first;
    return additionsOf(things, rows, fusion_ ? fusion_->faces() : MeshSoup(), *map_);
  }
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
  bool finds_things_;
  StandingThings things_{*map_};
  std::unique_ptr<DepthFusion> fusion_;
  std::vector<DepthSegment> segments_;
  double focal_ = 525;
  size_t images_ = 0, depths_ = 0;
};

/// Takes the poses of a trajectory.
void addGivenPoses(const AuditOptions& o, OpenedRecording* opened, Auditor* auditor) {
  // Given poses should be right within 2 cm.
  constexpr double kSigma = 0.02, kSigmaAngle = 0.5 * kDegree;
  Vector6 variance;
  variance << Eigen::Vector3d::Constant(kSigma * kSigma),
      Eigen::Vector3d::Constant(kSigmaAngle * kSigmaAngle);
  const Matrix6 covariance = variance.asDiagonal();
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
                   {*pose, covariance});
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
    auditor->add(localizer.input(), *r.images.front(), r.estimate);
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

void addOffered(const MapAdditions& additions, const Eigen::Vector3d& origin,
                nlohmann::json* summary) {
  nlohmann::json& list = (*summary)["offered"] = nlohmann::json::array();
  for (const AddedThing& added : additions.things) {
    const Eigen::Vector3d low = added.thing.box.min() + origin,
                          high = added.thing.box.max() + origin;
    list.push_back({{"number", added.thing.number},
                    {"lowest", {low.x(), low.y(), low.z()}},
                    {"highest", {high.x(), high.y(), high.z()}},
                    {"stood_for_s", added.thing.stood_for},
                    {"lines", added.lines.size()},
                    {"faces", added.faces.triangles.size()}});
  }
  (*summary)["offered_markings"] = additions.markings.size();
  (*summary)["without_parts"] = additions.without_parts;
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
  if (!summary.contains("offered")) return;
  for (const auto& thing : summary["offered"])
    std::printf("  offered       thing_%d at %s, which stood for %.0f s: %zu lines, %zu faces\n",
                thing["number"].get<int>(), box(thing).c_str(), thing["stood_for_s"].get<double>(),
                thing["lines"].get<size_t>(), thing["faces"].get<size_t>());
}

void printOffer(const AuditOptions& o, const nlohmann::json& summary) {
  const size_t markings = summary["offered_markings"], short_time = summary["stood_too_short"],
               without = summary["without_parts"];
  if (short_time > 0)
    std::printf("%zu more stood for less than %.0f s (--add-after)\n", short_time, o.add_after);
  if (without > 0)
    std::printf("%zu more have neither lines nor surfaces that were seen well\n", without);
  if (summary["offered"].empty() && markings == 0)
    std::printf("there is nothing to add, so there is no file %s\n", o.add.c_str());
  else
    std::printf("additions: %s (%zu things, %zu markings); `--set map.additions=%s` adds them\n",
                o.add.c_str(), summary["offered"].size(), markings, o.add.c_str());
}

/// @throws InputError when depth can show nothing that the model lacks.
void requireDepth(const AuditOptions& o, const Auditor& auditor) {
  const StandingThings& things = auditor.things();
  if (things.depths() == 0)
    throw InputError(o.recording + ": the recording has no depth, so --add can find nothing");
  if (2 * things.refused() > things.depths())
    throw InputError(o.recording + ": " + std::to_string(things.refused()) + " of " +
                     std::to_string(things.depths()) +
                     " depth images do not lie on the model (scale, mounting?), so --add can find "
                     "nothing");
}

/// @throws InputError when --add would overwrite what somebody else has written, or what is read.
void requireOwnFile(const AuditOptions& o, const OpenedRecording& opened) {
  std::error_code ignored;
  for (const std::string& file : namesIn(opened.map->params().map.additions))
    if (std::filesystem::equivalent(file, o.add, ignored))
      throw InputError(o.add + ": the audit reads this file, so --add cannot write it");
  if (std::filesystem::is_regular_file(o.add, ignored) &&
      std::filesystem::file_size(o.add, ignored) > 0 && !isAdditionsFile(o.add))
    throw InputError(o.add + ": exists and was not written by --add; it is not overwritten");
  const auto full = [](const std::string& file) {
    return std::filesystem::absolute(file).lexically_normal();
  };
  for (const std::string& file : {o.out, o.obj, o.picture})
    if (!file.empty() && full(file) == full(o.add))
      throw InputError(o.add + ": is the file of another result as well");
}

int run(const AuditOptions& o) {
  for (const std::string& file : {o.out, o.obj, o.add}) checkOutput(file);
  checkPicture(o.picture);
  RecordingOptions options = o;
  if (!o.poses.empty()) options.global = true;  // needs no initial pose
  OpenedRecording opened = openRecording(options, true);
  if (!o.add.empty() && !opened.map->visibility().scene())
    throw InputError(opened.model_file +
                     ": the model has no faces, so --add cannot tell what it lacks");
  if (!o.add.empty()) requireOwnFile(o, opened);
  Auditor auditor(opened.map, !o.add.empty());
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
  nlohmann::json summary = summaryOf(auditor, rows);
  if (!o.add.empty()) {
    requireDepth(o, auditor);
    MapAdditions additions = auditor.additions(rows, o.add_after);
    if (!o.add_markings) additions.markings.clear();
    const Eigen::Vector3d& origin = opened.map->mesh().origin;
    // An empty file is no model, and one of an earlier audit would be taken for the result.
    if (!additions.things.empty() || !additions.markings.empty())
      writeAdditions(o.add, additions, origin);
    else if (isAdditionsFile(o.add))
      std::filesystem::remove(o.add);
    addOffered(additions, origin, &summary);
    summary["stood_too_short"] = auditor.things().countBelow(o.add_after);
  }
  if (o.json) {
    std::printf("%s\n", textOf(summary).c_str());
    return kExitOk;
  }
  print(summary);
  if (auditor.depths() == 0)
    std::printf("  the recording has no depth, so new lines are not looked for\n");
  std::printf("table: %s; `--set map.confidence=%s` leaves out what is gone\n", o.out.c_str(),
              o.out.c_str());
  if (!o.add.empty()) printOffer(o, summary);
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
  c->add_option("--add", o->add,
                "OBJ file for what stands where the model has nothing, for map.additions; needs "
                "depth");
  c->add_option("--add-after", o->add_after,
                "time for which a thing must have stood at its place to be offered, s; default: 30")
      ->check(numberFrom(0, 1e6));
  c->add_flag("--add-markings", o->add_markings,
              "write the lines on surfaces of the model as well; default: things only");
  c->add_flag("--json", o->json, "print the summary as JSON; default: as text");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
