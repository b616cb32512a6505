// Preloaded into the tool or the editor, plays a driver that is reset: in the first so many frames that
// FURROW_LOSSES says, glGetGraphicsResetStatus finds the context lost.

#include <dlfcn.h>

#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace {

using Find = void* (*)(void*, const char*);
using GetProcAddress = void (*(*)(const char*))();

GetProcAddress get_proc_address;

unsigned resetStatus() {
  constexpr unsigned kNoError = 0, kInnocentContextReset = 0x8254;
  static int losses = std::atoi(std::getenv("FURROW_LOSSES"));
  return losses > 0 ? (--losses, kInnocentContextReset) : kNoError;
}

bool findsFunctions(const char* name) {
  for (const char* finder : {"eglGetProcAddress", "glXGetProcAddress", "glXGetProcAddressARB"})
    if (std::strcmp(name, finder) == 0) return true;
  return false;
}

void (*getProcAddress(const char* name))() {
  if (std::strcmp(name, "glGetGraphicsResetStatus") == 0) return reinterpret_cast<void (*)()>(resetStatus);
  if (findsFunctions(name)) return reinterpret_cast<void (*)()>(getProcAddress);
  return get_proc_address(name);
}

}  // namespace

extern "C" void* dlsym(void* handle, const char* name) {
  // Of glibc since 2.34, and before that on x86-64 and ARM.
  static const Find real = [] {
    void* symbol = nullptr;
    for (const char* version : {"GLIBC_2.34", "GLIBC_2.2.5", "GLIBC_2.17"})
      if (!symbol) symbol = dlvsym(RTLD_NEXT, "dlsym", version);
    return reinterpret_cast<Find>(symbol);
  }();
  void* found = real(handle, name);
  if (!found || !findsFunctions(name)) return found;
  get_proc_address = reinterpret_cast<GetProcAddress>(found);
  return reinterpret_cast<void*>(getProcAddress);
}
