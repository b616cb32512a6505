// The one translation unit that holds tinygltf's code: Debian's library is built with an image decoder that
// furrow does not want.

#define TINYGLTF_IMPLEMENTATION
#include "pipeline/import/gltf_document.h"
