#include "edge_mcl/core/image/picture_file.h"

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {
namespace {

bool encode(const std::string& ending, const cv::Mat& picture, const std::vector<int>& options,
            std::vector<uchar>* bytes) {
  try {
    return cv::imencode(ending, picture, *bytes, options);
  } catch (const cv::Exception&) {
    return false;
  }
}

/// The reason why writePicture() refuses a name.
std::string noFormat(const std::string& file) {
  return file + ": cannot be written: the ending names no picture format (.png, .jpg)";
}

}  // namespace

bool isPictureName(const std::string& file) {
  // Some formats of OpenCV take grey pictures only, or have to be switched on.
  const cv::Mat picture(8, 8, CV_8UC3, cv::Scalar(0, 0, 0));
  const std::string ending = std::filesystem::path(file).extension().string();
  std::vector<uchar> bytes;
  return !ending.empty() && encode(ending, picture, {}, &bytes);
}

void requirePictureName(const std::string& file) {
  if (!isPictureName(file)) throw InputError(noFormat(file));
}

void writePicture(const std::string& file, const cv::Mat& picture,
                  const std::vector<int>& options) {
  namespace fs = std::filesystem;
  const std::string ending = fs::path(file).extension().string();
  std::vector<uchar> bytes;
  if (ending.empty() || !encode(ending, picture, options, &bytes)) throw InputError(noFormat(file));
  const std::string partial = file + ".part";
  std::error_code error;
  {
    std::ofstream out(partial, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) {
      fs::remove(partial, error);
      throw InputError(file + ": cannot be written");
    }
  }
  fs::rename(partial, file, error);
  if (error) throw InputError(file + ": cannot be written: " + error.message());
}

}  // namespace edge_mcl
