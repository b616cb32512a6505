#include <cstdint>
#include <cstdlib>
#include <string>

#include "pipeline/error.h"
#include "pipeline/recipe/recipe.h"

// Any text: it is refused with an Error, or makes a recipe that is the same after it was written and read
// once more.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace furrow::pipeline;
  std::string written;
  try {
    written = recipeText(parseRecipe({data, data + size}, "fuzz.json"), "fuzz.json");
  } catch (const Error&) {
    return 0;
  }
  if (recipeText(parseRecipe(written, "fuzz.json"), "fuzz.json") != written) std::abort();
  return 0;
}
