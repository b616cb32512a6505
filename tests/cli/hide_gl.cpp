// Preloaded into the tool, hides every OpenGL library from it. The file that FURROW_HIDDEN names gets a line
// for each try to open one, and for each that came in unasked as another library's dependency.

#include <dlfcn.h>
#include <link.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace {

bool isOpenGl(const char* name) {
  for (const char* library : {"libEGL", "libGL", "libOpenGL"})
    if (std::strstr(name, library)) return true;
  return false;
}

void note(const char* name) {
  if (const char* log = std::getenv("FURROW_HIDDEN"))
    if (std::FILE* file = std::fopen(log, "a")) {
      std::fprintf(file, "%s\n", name);
      std::fclose(file);
    }
}

struct AtExit {
  ~AtExit() {
    dl_iterate_phdr(
        [](dl_phdr_info* info, size_t, void*) {
          if (isOpenGl(info->dlpi_name)) note(info->dlpi_name);
          return 0;
        },
        nullptr);
  }
} at_exit;

}  // namespace

extern "C" void* dlopen(const char* name, int flags) {
  if (name && isOpenGl(name)) {
    note(name);
    return nullptr;
  }
  static const auto real = reinterpret_cast<void* (*)(const char*, int)>(dlsym(RTLD_NEXT, "dlopen"));
  return real(name, flags);
}
