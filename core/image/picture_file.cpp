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

}  // namespace

void writePicture(const std::string& file, const cv::Mat& picture,
                  const std::vector<int>& options) {
  namespace fs = std::filesystem;
  const std::string ending = fs::path(file).extension().string();
  std::vector<uchar> bytes;
  if (ending.empty() || !encode(ending, picture, options, &bytes))
    throw InputError(file + ": cannot be written: the ending names no picture format (.png, .jpg)");
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
