#include "slipstream/view/off_screen.h"

#include <algorithm>
#include <array>

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/view/window.h"

namespace slipstream::opengl {
namespace {

EGLDisplay display_without_surface() {
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  }
  return eglGetDisplay(EGL_DEFAULT_DISPLAY);
}

}  // namespace

/// A context of EGL that is current without a surface.
class OffScreenContext::Egl {
 public:
  /// Null where EGL has none.
  static std::unique_ptr<Egl> make() {
    if (!epoxy_has_egl()) return nullptr;
    const EGLDisplay display = display_without_surface();
    if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE) {
      return nullptr;
    }
    auto egl = std::unique_ptr<Egl>(new Egl(display));
    if (!egl->begin()) egl.reset();
    return egl;
  }
  Egl(const Egl&) = delete;
  Egl& operator=(const Egl&) = delete;
  ~Egl() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }

 private:
  explicit Egl(EGLDisplay display) : display_(display) {}

  bool begin() {
    // Without a desktop there are configurations for pixel buffers only; none is made.
    constexpr std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                           EGL_OPENGL_BIT, EGL_NONE};
    constexpr std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                            3,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            3,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE ||
        eglChooseConfig(display_, wanted.data(), &config, 1, &count) == EGL_FALSE || count == 0) {
      return false;
    }
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version.data());
    return context_ != EGL_NO_CONTEXT &&
           eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }

  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

class OffScreenContext::HiddenWindow {
 public:
  HiddenWindow() : window_(system_, {.size = {64, 64}, .visible = false}) {}

 private:
  WindowSystem system_;
  Window window_;
};

OffScreenContext::OffScreenContext() : egl_(Egl::make()) {
  if (egl_) return;
  try {
    hidden_window_ = std::make_unique<HiddenWindow>();
  } catch (const WorldError& error) {
    throw WorldError(fmt::format("cannot draw: EGL gives no OpenGL 3.3 without a surface, and {}",
                                 error.what()));
  }
}

OffScreenContext::~OffScreenContext() = default;

RenderTarget::RenderTarget(Size size)
    : size_(size),
      colour_(make_renderbuffer()),
      depth_(make_renderbuffer()),
      framebuffer_(make_framebuffer()) {
  GLint longest = 0;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &longest);
  if (std::max(size.width, size.height) > longest || std::min(size.width, size.height) < 1) {
    throw Error(fmt::format("a picture of {}x{} cannot be drawn; 1 to {} pixels on a side",
                            size.width, size.height, longest));
  }
  const auto allocate = [&](const Resource& buffer, GLenum format) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffer.number());
    glRenderbufferStorage(GL_RENDERBUFFER, format, size.width, size.height);
  };
  allocate(colour_, GL_RGBA8);
  allocate(depth_, GL_DEPTH_COMPONENT24);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.number());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                            colour_.number());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.number());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw WorldError(
        fmt::format("OpenGL has no memory for a picture of {}x{}", size.width, size.height));
  }
}

void RenderTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.number());
  glViewport(0, 0, size_.width, size_.height);
}

Image<Colour> read_pixels(Size size) {
  static_assert(sizeof(Colour) == 3);
  Image<Colour> upside_down(size), picture(size);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.row(0));
  for (int row = 0; row < size.height; ++row) {
    std::copy_n(upside_down.row(size.height - 1 - row), size.width, picture.row(row));
  }
  return picture;
}

}  // namespace slipstream::opengl
