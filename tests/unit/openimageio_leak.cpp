// For AddressSanitizer: OpenImageIO 2.4 jumps out of its PNG reader past a string of its own, 31 bytes for
// every cut file. Only the slow unwinder sees that it is OpenImageIO's.

extern "C" const char* __asan_default_options() {
  return "fast_unwind_on_malloc=0";
}
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOpenImageIO";
}
