#pragma once

// The parts of the demo face, each made by a file of its own. Centimetres, head space (content/head.h);
// mirror images of each other about x = 0.

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "content/expressions.h"
#include "content/surface_mesh.h"

namespace furrow::content {

enum FaceMaterial : uint32_t { kSkin, kEar, kLid, kMouth, kTeeth, kHairs, kBrows, kShirt, kEye };

// A surface that goes with the expressions.
struct FacePart {
  SurfaceMesh mesh;
  std::vector<HeadPoint> points;    // what moves each point of the mesh
  std::vector<glm::dvec3> colors;   // a point, linear; what the material's colour is multiplied by
  std::vector<uint32_t> materials;  // a triangle

  // A point that moves by itself.
  uint32_t addPoint(glm::dvec3 position, bool lower_lip = false, bool lower_lid = false);
};

// A part and its mirror image, vertex for vertex.
FacePart withMirrorImage(FacePart part);

// skin.cpp: the head from the collar to the crown, cut open at the eyes and the mouth, with the insides of
// the lids and a pocket behind the lips.
FacePart faceSkin();
FacePart teeth();  // teeth.cpp: with gums and tongue
// ears.cpp: `earDistance` of the left ear alone, a signed distance.
FacePart ears();
double earDistance(glm::dvec3 p);
// hair.cpp
FacePart brows();
FacePart lashes();
FacePart hair();
// shirt.cpp: a collar and what of the shoulders a portrait shows.
FacePart shirt();
// eye.cpp: about the origin, looking along +Z, in metres.
Mesh eyeball();
Image eyeColors();  // its colour map

// face_paint.cpp: what an artist would paint on the skin.
struct Painting {
  glm::vec4 mask_a, mask_b;    // forehead, glabella, crow's feet, bunny lines; mouth, chin, lips, neck
  glm::vec3 eye, nose, mouth;  // across the creases, unit
  glm::vec3 bias;              // of forehead, eyes and mouth; neutral 0.5
};
Painting paintingAt(glm::dvec3 p);
glm::dvec3 skinColor(glm::dvec3 p);
// What the head itself keeps off of the light that comes from all around, for each colour.
glm::dvec3 skinOcclusion(glm::dvec3 p, glm::dvec3 normal);
double lipsAt(glm::dvec3 p);  // 1 within the red of the lips
// How thick the hair grows at p, [0, 1]: on the scalp, and in the brows.
double hairAt(glm::dvec3 p);
double browAt(glm::dvec3 p);

}  // namespace furrow::content
