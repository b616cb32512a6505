#pragma once

// Textures of the face's skin, in the UVs of faceSkin().

#include "content/face_parts.h"
#include "content/scene.h"

namespace furrow::content {

struct SkinMaps {
  Image color;   // what skinColor() says, with pores, stubble and the roots of the hair
  Image normal;  // pores, the fine net of lines between them, and the lines of the lips
};
SkinMaps skinMaps(const FacePart& skin);

}  // namespace furrow::content
