#pragma once

#include "content/scene.h"

namespace furrow::content {

// A man's head and collar: 30 ARKit-named morph targets, clip "performance". Masks in _MASK_A: forehead,
// glabella, crow's feet, bunny lines; in _MASK_B: beside the mouth, chin, lips, neck; directions across the
// creases in _DIR_EYE, _DIR_NOSE and _DIR_MOUTH; rest bias of forehead, eyes and mouth in _BIAS (neutral
// 0.5). The skin and the eyes have colour maps, the skin a normal map, too; their COLOR_0 is what the head
// keeps the light off, elsewhere it is the colour.
Scene buildFace();

// A bomber jacket: joints hips, spine, chest, and an upper arm and a forearm a side, each with a helper that
// turns half as far; clips "bend" (elbows), "raise" (arms up, then down), "twist", "lean" and "sway". Masks
// in _MASK_A: elbow, shoulder and armpit, waist, waist; in _MASK_B.r: above hem and cuffs. Directions across
// the folds in _DIR_ALONG, _DIR_AROUND, _DIR_TWIST_LEFT and _DIR_TWIST_RIGHT; rest bias in _BIAS.x (neutral
// 0.5).
Scene buildJacket();

// A shirt sleeve on an arm: joints upperArm, foreArm, foreArmTwist, hand; clips "bend" and "twist". Masks in
// _MASK_A: inner side of the elbow, twist below the elbow; rest bias in COLOR_0.r (neutral 0.5).
Scene buildSleeve();

// A square of cloth with the morph targets shear, pinch and squeeze; clip "pull". _DIR_PINCH runs around the
// pinch, _MASK_A.r covers it.
Scene buildPanel();

}  // namespace furrow::content
