// q of a triangle from its posed edges and a layer's coefficients. The expression order is that of
// src/compress.cpp.

float measureTriangle(uint measure, vec3 e1, vec3 e2, vec3 c) {
  precise float q = 1.0;
  if (measure == kMeasureDirectional) {
    precise float x = c.x * e1.x + c.y * e2.x;
    precise float y = c.x * e1.y + c.y * e2.y;
    precise float z = c.x * e1.z + c.y * e2.z;
    q = ((x * x + y * y) + z * z) * frame.inverse_scale2;
  } else if (measure == kMeasureArea) {
    precise float x = e1.y * e2.z - e1.z * e2.y;
    precise float y = e1.z * e2.x - e1.x * e2.z;
    precise float z = e1.x * e2.y - e1.y * e2.x;
    precise float squared = (x * x + y * y) + z * z;
    q = sqrt(squared) * c.x * frame.inverse_scale2;
  } else if (measure == kMeasurePrincipal) {
    precise vec3 f1 = c.x * e1;
    precise vec3 f2 = c.y * e1 + c.z * e2;
    precise float f11 = (f1.x * f1.x + f1.y * f1.y) + f1.z * f1.z;
    precise float f22 = (f2.x * f2.x + f2.y * f2.y) + f2.z * f2.z;
    precise float f12 = (f1.x * f2.x + f1.y * f2.y) + f1.z * f2.z;
    precise float halved = 0.5 * (f11 - f22);
    precise float spread = sqrt(halved * halved + f12 * f12);
    q = (0.5 * (f11 + f22) - spread) * frame.inverse_scale2;
  }
  return q >= 0.0 ? min(q, 4.0) : q < 0.0 ? 0.0 : 1.0;
}

uint coefficientCount(uint measure) {
  return measure == kMeasureDirectional ? 2u : measure == kMeasureArea ? 1u : measure == kMeasurePrincipal ? 3u : 0u;
}
