#include <cstdint>
#include <cstdlib>
#include <set>

#include "pipeline/cook/manifest.h"
#include "pipeline/error.h"

// Any text: it is refused with an Error, or lists assets that each have a source and an output of their own.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace furrow::pipeline;
  try {
    std::set<std::filesystem::path> outputs;
    for (const ManifestAsset& asset : parseManifest({data, data + size}, "fuzz.json"))
      if (asset.request.source.name().empty() || !outputs.insert(asset.output).second) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
