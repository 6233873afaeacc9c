// For the address sanitizer: OpenGL drivers stay loaded until the process ends, so that
// leak reports name the libraries and driver_leaks.txt can suppress them.
#include <dlfcn.h>

int dlclose(void*) noexcept {
  return 0;
}
