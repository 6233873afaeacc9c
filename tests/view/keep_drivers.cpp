// Under the address sanitizer: OpenGL drivers stay loaded until the process ends, so that what they
// have not freed is told with their names, which driver_leaks.txt passes over.
#include <dlfcn.h>

int dlclose(void*) noexcept {
  return 0;
}
