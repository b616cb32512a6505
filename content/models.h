#pragma once

#include "content/scene.h"

namespace furrow::content {

// A man's head and collar: 30 ARKit-named morph targets, clip "performance". Masks in _MASK_A: forehead,
// glabella, crow's feet, bunny lines; in _MASK_B: beside the mouth, chin, lips; directions across the creases
// in _DIR_EYE, _DIR_NOSE and _DIR_MOUTH; rest bias in _BIAS.x (neutral 0.5); colours in COLOR_0.
Scene buildFace();

// A shirt sleeve on an arm: joints upperArm, foreArm, foreArmTwist, hand; clips "bend" and "twist". Masks in
// _MASK_A: inner side of the elbow, twist below the elbow; rest bias in COLOR_0.r (neutral 0.5).
Scene buildSleeve();

}  // namespace furrow::content
