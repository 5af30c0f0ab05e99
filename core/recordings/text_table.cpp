#include "edge_mcl/core/recordings/text_table.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

/// Calls f(line_number, fields) for every line that is not empty or a comment.
template <class F>
void forEachLine(const std::string& file, F&& f) {
  // A folder can be opened, but not read.
  if (std::filesystem::is_directory(file)) throw InputError(file + ": cannot be read");
  std::ifstream in(file);
  if (!in) throw InputError(file + ": cannot be read");
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    const auto comment = text.find('#');
    if (comment != std::string::npos) text.resize(comment);
    std::istringstream words(text);
    std::vector<std::string> fields;
    for (std::string word; words >> word;) fields.push_back(word);
    if (!fields.empty()) f(number, fields);
  }
}

double parseFinite(const std::string& text, const std::string& where) {
  size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != text.size() || !std::isfinite(value))
    throw InputError(where + ": '" + text + "' is not a finite number");
  return value;
}

}  // namespace

Trajectory readTrajectory(const std::string& file) {
  Trajectory trajectory;
  forEachLine(file, [&](int number, const std::vector<std::string>& fields) {
    const std::string where = file + ":" + std::to_string(number);
    if (fields.size() < 8) throw InputError(where + ": 'timestamp tx ty tz qx qy qz qw' expected");
    double v[8];
    for (int i = 0; i < 8; ++i) v[i] = parseFinite(fields[i], where);
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (std::abs(q.norm() - 1) > 0.01)
      throw InputError(where + ": the quaternion must have unit length");
    if (!trajectory.empty() && v[0] <= trajectory.back().time)
      throw InputError(where + ": time does not increase");
    StampedPose entry;
    entry.time = v[0];
    entry.time_text = fields[0];
    entry.pose.linear() = q.normalized().toRotationMatrix();
    entry.pose.translation() = Eigen::Vector3d(v[1], v[2], v[3]);
    trajectory.push_back(entry);
  });
  return trajectory;
}

std::string formatPose(const std::string& time_text, const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  std::ostringstream out;
  out << time_text << std::fixed << std::setprecision(9) << ' ' << t.x() << ' ' << t.y() << ' '
      << t.z() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w();
  return out.str();
}

std::vector<StampedFile> readFileList(const std::string& file) {
  std::vector<StampedFile> list;
  forEachLine(file, [&](int number, const std::vector<std::string>& fields) {
    const std::string where = file + ":" + std::to_string(number);
    if (fields.size() != 2) throw InputError(where + ": 'timestamp filename' expected");
    list.push_back({parseFinite(fields[0], where), fields[0], fields[1]});
  });
  return list;
}

}  // namespace edge_mcl
