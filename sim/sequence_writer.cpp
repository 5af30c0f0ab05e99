#include "edge_mcl/sim/sequence_writer.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/mesh/mesh_model.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

namespace fs = std::filesystem;

namespace {

std::string stamp(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", time);
  return text;
}

/// Returns a text as a quoted YAML scalar.
std::string quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

std::string cameraYaml(const CameraModel& c) {
  const bool fisheye = c.distortion == DistortionModel::kEquidistant;
  const bool rational = c.distortion == DistortionModel::kRationalPolynomial;
  const int count = fisheye ? 4 : rational ? 8 : 5;
  std::ostringstream out;
  out.precision(17);
  out << "image_width: " << c.width << "\nimage_height: " << c.height
      << "\ncamera_name: simulated\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [" << c.fx
      << ", 0, " << c.cx << ", 0, " << c.fy << ", " << c.cy << ", 0, 0, 1]\ndistortion_model: "
      << (fisheye    ? "equidistant"
          : rational ? "rational_polynomial"
                     : "plumb_bob")
      << "\ndistortion_coefficients:\n  rows: 1\n  cols: " << count << "\n  data: [";
  for (int i = 0; i < count; ++i) out << (i ? ", " : "") << c.coefficients[i];
  out << "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
      << "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [" << c.fx << ", 0, " << c.cx
      << ", 0, 0, " << c.fy << ", " << c.cy << ", 0, 0, 0, 1, 0]\n";
  return out.str();
}

/// Returns the mesh as OBJ text, sorted by material. The model file itself may have another format.
std::string objOf(const MeshModel& mesh) {
  std::ostringstream out;
  out.precision(9);  // enough digits to read back the same float
  for (const Eigen::Vector3f& v : mesh.vertices)
    out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  std::vector<size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return mesh.triangle_material[a] < mesh.triangle_material[b];
  });
  for (size_t k = 0; k < order.size(); ++k) {
    const uint32_t material = mesh.triangle_material[order[k]];
    if (k == 0 || material != mesh.triangle_material[order[k - 1]])
      out << "usemtl material_" << material << '\n';
    const auto& t = mesh.triangles[order[k]];
    out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
  for (const auto& line : mesh.lines) out << "l " << line[0] + 1 << ' ' << line[1] + 1 << '\n';
  return out.str();
}

}  // namespace

SequenceWriter::SequenceWriter(std::string directory, const RecordingSetup& setup,
                               const std::string& model_file, const std::vector<std::string>& notes)
    : directory_(std::move(directory)) {
  std::error_code error;
  const fs::path root(directory_);
  for (const char* name : {"rgb.txt", "depth.txt", "mask.txt", "groundtruth.txt", "odometry.txt",
                           "imu.txt", "model.obj", "camera.yaml", "sequence.yaml"})
    if (fs::exists(root / name, error))
      throw InputError(directory_ + ": holds a sequence already, or a part of one (" + name + ")");
  for (const char* sub : {"rgb", "depth", "mask"}) {
    fs::create_directories(root / sub, error);
    if (error) throw InputError((root / sub).string() + ": " + error.message());
  }
  writeText("model.obj", objOf(loadMesh(model_file, {})));
  writeText("camera.yaml", cameraYaml(setup.camera));
  std::istringstream numbers(formatPose("", setup.initial_pose));
  std::string list, word;
  while (numbers >> word) list += (list.empty() ? "" : ", ") + word;
  const fs::path full = fs::absolute(root).lexically_normal();
  const fs::path named =
      full.has_filename() ? full : full.parent_path();  // "out/" is named "out", too
  std::ostringstream description;
  description
      << "name: " << quoted(named.filename().string())
      << "\nsource: edge-mcl simulate\nlicence: the licence of the model\nreal: false\nup_axis: z"
      << "\ndepth_scale: " << setup.depth_scale << "\ninitial_pose: [" << list
      << "]\ninitial_std: [" << setup.initial_std_position << ", " << setup.initial_std_angle
      << "]\nnotes:\n";
  for (const std::string& note : notes) description << "  - " << quoted(note) << "\n";
  writeText("sequence.yaml", description.str());
  const auto open = [&](std::ofstream* stream, const char* name, const char* header) {
    stream->open(root / name, std::ios::trunc);
    append(stream, name, header);
  };
  open(&rgb_, "rgb.txt", "# timestamp filename");
  open(&depth_, "depth.txt", "# timestamp filename");
  open(&mask_, "mask.txt", "# timestamp filename");
  open(&truth_, "groundtruth.txt", "# timestamp tx ty tz qx qy qz qw (camera in the map)");
  open(&odometry_, "odometry.txt", "# timestamp tx ty tz qx qy qz qw (dead reckoning)");
}

void SequenceWriter::writeFile(const std::string& name, const std::vector<uint8_t>& bytes) {
  const fs::path file = fs::path(directory_) / name;
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out) return;
  std::error_code ignored;
  fs::remove(file, ignored);  // leave no incomplete image
  throw InputError(file.string() + ": cannot be written (disk full?); " + std::to_string(count_) +
                   " images are complete");
}

void SequenceWriter::writeText(const std::string& name, const std::string& text) {
  writeFile(name, std::vector<uint8_t>(text.begin(), text.end()));
}

void SequenceWriter::writeImage(const std::string& name, const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  // Without a compression level OpenCV uses the fastest level of libpng, and one row filter instead
  // of trying all.
  cv::imencode(".png", image, bytes,
               {cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY});
  writeFile(name, bytes);
}

void SequenceWriter::append(std::ofstream* list, const std::string& name, const std::string& line) {
  *list << line << '\n';
  list->flush();
  if (!*list)
    throw InputError((fs::path(directory_) / name).string() + ": cannot be written (disk full?); " +
                     std::to_string(count_) + " images are complete");
}

void SequenceWriter::write(const RecordedFrame& frame) {
  const std::string time = stamp(frame.time);
  char number[16];
  std::snprintf(number, sizeof number, "%06zu.png", count_);
  const std::string rgb = std::string("rgb/") + number, depth = std::string("depth/") + number,
                    mask = std::string("mask/") + number;
  writeImage(depth, frame.depth);
  writeImage(mask, frame.mask);
  writeImage(rgb, frame.color);
  if (frame.truth) append(&truth_, "groundtruth.txt", formatPose(time, *frame.truth));
  if (frame.odometry) append(&odometry_, "odometry.txt", formatPose(time, *frame.odometry));
  append(&depth_, "depth.txt", time + " " + depth);
  append(&mask_, "mask.txt", time + " " + mask);
  // rgb.txt comes last: all files of an image that it lists are complete.
  append(&rgb_, "rgb.txt", time + " " + rgb);
  ++count_;
}

void SequenceWriter::writeImu(const std::vector<ImuReading>& readings) {
  std::ostringstream out;
  out << "# timestamp wx wy wz ax ay az (body x forward, z up; rad/s, m/s^2 with gravity)\n";
  out.precision(9);
  for (const ImuReading& r : readings) {
    out << stamp(r.time);
    for (const double v : {r.angular_velocity.x(), r.angular_velocity.y(), r.angular_velocity.z(),
                           r.specific_force.x(), r.specific_force.y(), r.specific_force.z()})
      out << ' ' << v;
    out << '\n';
  }
  writeText("imu.txt", out.str());
}

}  // namespace edge_mcl
