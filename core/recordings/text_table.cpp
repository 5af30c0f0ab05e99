#include "edge_mcl/core/recordings/text_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
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
    std::replace(text.begin(), text.end(), ',', ' ');
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

/// A stamp in seconds. Since 1970 there have been more than 1e9 and less than 1e10 s, so the size
/// of a number tells its unit.
struct Stamp {
  double seconds;
  std::string text;  // in seconds
};

Stamp stampOf(const std::string& text, const std::string& where) {
  constexpr double kLatest = 1e11;  // s, about 3000 years
  const double value = parseFinite(text, where);
  if (std::abs(value) < kLatest) return {value, text};
  size_t digits = 3;
  while (digits < 9 && std::abs(value) >= kLatest * std::pow(10, digits)) digits += 3;
  if (std::abs(value) >= kLatest * std::pow(10, digits))
    throw InputError(where + ": '" + text + "' is not a time");
  const auto point = text.find_first_not_of("0123456789");
  // Only whole numbers keep all their digits.
  if (point != std::string::npos || text.size() <= digits) {
    char seconds[40];
    std::snprintf(seconds, sizeof seconds, "%.6f", value / std::pow(10, digits));
    return {value / std::pow(10, digits), seconds};
  }
  const std::string seconds =
      text.substr(0, text.size() - digits) + "." + text.substr(text.size() - digits);
  return {std::stod(seconds), seconds};
}

enum class QuaternionOrder { kXyzw, kWxyz, kUnknown };

/// The order that names of columns in the lines before the first numbers tell: what stands beside
/// w. Without names it is that of TUM, but tables with commas come in both orders.
QuaternionOrder orderOf(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> names;
  std::string line;
  while (std::getline(in, line)) {
    const auto first = line.find_first_not_of(" \t");
    if (first == std::string::npos) continue;
    if (line[first] != '#' && std::isalpha(static_cast<unsigned char>(line[first])) == 0) break;
    names.emplace_back();  // a name does not go on in the next line
    for (const char c : line)
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.')
        names.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      else if (!names.back().empty())
        names.emplace_back();
  }
  names.erase(std::remove(names.begin(), names.end(), ""), names.end());
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    // "w", "qw", "q_w", "q_RS_w", "quat_w", "orientation.w", but not a word like "now".
    const bool is_w = name.back() == 'w' &&
                      (name.size() == 1 || name[0] == 'q' || name.find('_') != std::string::npos ||
                       name.find('.') != std::string::npos);
    if (!is_w) continue;
    if (i + 1 < names.size() && names[i + 1].back() == 'x') return QuaternionOrder::kWxyz;
    if (i > 0 && names[i - 1].back() == 'z') return QuaternionOrder::kXyzw;
  }
  return line.find(',') == std::string::npos ? QuaternionOrder::kXyzw : QuaternionOrder::kUnknown;
}

}  // namespace

double stampIn(std::string* text, const std::string& where) {
  const Stamp stamp = stampOf(*text, where);
  *text = stamp.text;
  return stamp.seconds;
}

Trajectory readTrajectory(const std::string& file) {
  Trajectory trajectory;
  const QuaternionOrder order = orderOf(file);
  forEachLine(file, [&](int number, const std::vector<std::string>& fields) {
    const std::string where = file + ":" + std::to_string(number);
    // The names of the columns, where no '#' is before them.
    if (number == 1 && std::isalpha(static_cast<unsigned char>(fields[0][0])) &&
        fields[0].rfind("nan", 0) != 0 && fields[0].rfind("inf", 0) != 0)
      return;
    if (order == QuaternionOrder::kUnknown)
      throw InputError(file +
                       ": a table with commas needs a first line that names the columns, e.g. "
                       "'#timestamp,tx,ty,tz,qw,qx,qy,qz'");
    if (fields.size() < 8) throw InputError(where + ": 'timestamp tx ty tz qx qy qz qw' expected");
    const Stamp stamp = stampOf(fields[0], where);
    double v[8];
    v[0] = stamp.seconds;
    for (int i = 1; i < 8; ++i) v[i] = parseFinite(fields[i], where);
    if (order == QuaternionOrder::kWxyz) std::rotate(v + 4, v + 5, v + 8);
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (std::abs(q.norm() - 1) > 0.01)
      throw InputError(where + ": the quaternion must have unit length");
    if (!trajectory.empty() && v[0] <= trajectory.back().time)
      throw InputError(where + ": time does not increase");
    StampedPose entry;
    entry.time = v[0];
    entry.time_text = stamp.text;
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

const char* const kEurocColumns =
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z "
    "[]";

std::string formatEurocPose(const std::string& time_text, const Pose& pose) {
  constexpr size_t kDigits = 9;  // of a nanosecond
  std::string time = time_text;
  if (time.find_first_not_of("0123456789.") == std::string::npos) {
    const size_t point = std::min(time.find('.'), time.size());
    std::string fraction = time.substr(std::min(point + 1, time.size()), kDigits);
    fraction.resize(kDigits, '0');
    time = time.substr(0, point) + fraction;
    time.erase(0, std::min(time.find_first_not_of('0'), time.size() - 1));
  }
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  std::ostringstream out;
  out << time << std::fixed << std::setprecision(9) << ',' << t.x() << ',' << t.y() << ',' << t.z()
      << ',' << q.w() << ',' << q.x() << ',' << q.y() << ',' << q.z();
  return out.str();
}

std::vector<StampedFile> readFileList(const std::string& file) {
  std::vector<StampedFile> list;
  forEachLine(file, [&](int number, const std::vector<std::string>& fields) {
    const std::string where = file + ":" + std::to_string(number);
    if (fields.size() != 2) throw InputError(where + ": 'timestamp filename' expected");
    const Stamp stamp = stampOf(fields[0], where);
    list.push_back({stamp.seconds, stamp.text, fields[1]});
  });
  return list;
}

}  // namespace edge_mcl
