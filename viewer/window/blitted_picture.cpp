#include "edge_mcl/viewer/window/blitted_picture.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

namespace edge_mcl {

void BlittedPicture::set(const cv::Mat& picture, const cv::Rect& area) {
  picture_ = picture.isContinuous() ? picture : picture.clone();
  area_ = area;
  changed_ = true;
}

void BlittedPicture::draw(int window_height) {
  if (picture_.empty()) return;
  if (texture_ == 0) {
    glGenTextures(1, &texture_);
    glGenFramebuffers(1, &framebuffer_);
  }
  if (changed_) {
    glBindTexture(GL_TEXTURE_2D, texture_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (loaded_ != picture_.size()) {
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture_.cols, picture_.rows, 0, GL_BGR,
                   GL_UNSIGNED_BYTE, picture_.data);
      // The texture has no mipmaps, so the filter must not use them.
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
      loaded_ = picture_.size();
    } else {
      glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture_.cols, picture_.rows, GL_BGR,
                      GL_UNSIGNED_BYTE, picture_.data);
    }
    glBindTexture(GL_TEXTURE_2D, 0);
    changed_ = false;
  }
  GLint before = 0;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &before);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_, 0);
  glDisable(GL_SCISSOR_TEST);
  // The rows of a picture go down, the rows of the window go up.
  const int top = window_height - area_.y, bottom = top - area_.height;
  glBlitFramebuffer(0, 0, picture_.cols, picture_.rows, area_.x, top, area_.x + area_.width, bottom,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(before));
}

}  // namespace edge_mcl
