#include "edge_mcl/nodes/localizer/particle_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

void writeParticles(const std::string& file, const ParticleSet& particles) {
  const std::string partial = file + ".part";
  {
    std::ofstream out(partial);
    out << "# log_weight tx ty tz qx qy qz qw (T_map_base)\n";
    for (size_t i = 0; i < particles.poses.size(); ++i) {
      std::ostringstream weight;
      weight.precision(17);
      weight << particles.log_weights[i];
      out << formatPose(weight.str(), particles.poses[i]) << '\n';
    }
    if (!out.flush()) throw InputError(file + ": cannot be written");
  }
  std::error_code error;
  std::filesystem::rename(partial, file, error);
  if (error) throw InputError(file + ": cannot be written: " + error.message());
}

ParticleSet readParticles(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file + ": cannot be read");
  ParticleSet particles;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    double w = NAN, x = NAN, y = NAN, z = NAN;
    Eigen::Quaterniond q;
    if (!(fields >> w >> x >> y >> z >> q.x() >> q.y() >> q.z() >> q.w()) ||
        !std::isfinite(w + x + y + z) || !(std::abs(q.norm() - 1) < 0.01))
      throw InputError(file + ": line " + std::to_string(number) +
                       " is not a weight and a pose with a unit quaternion");
    Pose pose = Pose::Identity();
    pose.linear() = q.normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(x, y, z);
    particles.poses.push_back(pose);
    particles.log_weights.push_back(w);
  }
  if (particles.poses.empty()) throw InputError(file + ": the file has no particles");
  return particles;
}

}  // namespace edge_mcl
