// Preloaded into the tool, hides every OpenGL library from it and notes each try to open one in the file that
// FURROW_HIDDEN names.

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

extern "C" void* dlopen(const char* name, int flags) {
  if (name)
    for (const char* library : {"libEGL", "libGL", "libOpenGL"})
      if (std::strstr(name, library)) {
        if (const char* log = std::getenv("FURROW_HIDDEN"))
          if (std::FILE* file = std::fopen(log, "a")) {
            std::fprintf(file, "%s\n", name);
            std::fclose(file);
          }
        return nullptr;
      }
  static const auto real = reinterpret_cast<void* (*)(const char*, int)>(dlsym(RTLD_NEXT, "dlopen"));
  return real(name, flags);
}
