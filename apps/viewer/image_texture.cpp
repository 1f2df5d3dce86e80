#include "apps/viewer/image_texture.h"

#include <GLFW/glfw3.h>  // includes OpenGL's header

#include <utility>

namespace cosplat::viewer {

ImageTexture::ImageTexture(DeviceTextureMaker make_device_texture)
    : make_device_texture_(std::move(make_device_texture)) {
  glGenTextures(1, &name_);
  glBindTexture(GL_TEXTURE_2D, name_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

ImageTexture::~ImageTexture() {
  device_texture_.reset();
  glDeleteTextures(1, &name_);
}

void ImageTexture::Upload(const Image8& image) {
  Resize(image.width, image.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D,
                  0,
                  0,
                  0,
                  image.width,
                  image.height,
                  GL_RGBA,
                  GL_UNSIGNED_BYTE,
                  image.data.data());
}

void ImageTexture::Show(const DeviceImage& picture) {
  Resize(picture.width(), picture.height());
  if (!device_texture_) device_texture_ = make_device_texture_(name_);
  try {
    device_texture_->Fill(picture);
  } catch (...) {
    device_texture_.reset();  // its state is unknown
    throw;
  }
}

// Binds the texture. The device holds the old storage and must release it first.
void ImageTexture::Resize(int width, int height) {
  glBindTexture(GL_TEXTURE_2D, name_);
  if (width == width_ && height == height_) return;
  device_texture_.reset();
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  width_ = width;
  height_ = height;
}

}  // namespace cosplat::viewer
