// q of each triangle and layer. The expression order of the measures is that of src/compress.cpp.

FURROW_READ(0, uint, surface_indices);
FURROW_READ(1, float, coefficients);
FURROW_READ(2, float, positions);
FURROW_WRITE(3, float, triangle_q);

vec3 position(uint corner) {
  uint word = 3u * surface_indices[corner];
  return vec3(positions[word], positions[word + 1u], positions[word + 2u]);
}

void main() {
  uint t = invocationIndex();
  if (t >= frame.triangles) return;
  vec3 p0 = position(3u * t);
  precise vec3 e1 = position(3u * t + 1u) - p0;
  precise vec3 e2 = position(3u * t + 2u) - p0;
  for (uint layer = 0u; layer < frame.layers; ++layer) {
    uint measure = frame.layer[layer].measure;
    uint first = frame.layer[layer].first_coefficient;
    bool in_no_ring = false;
    precise float q = 1.0;
    if (measure == kMeasureDirectional) {
      float c0 = coefficients[first + 2u * t];
      float c1 = coefficients[first + 2u * t + 1u];
      in_no_ring = c0 == 0.0 && c1 == 0.0;
      precise float x = c0 * e1.x + c1 * e2.x;
      precise float y = c0 * e1.y + c1 * e2.y;
      precise float z = c0 * e1.z + c1 * e2.z;
      q = ((x * x + y * y) + z * z) * frame.inverse_scale2;
    } else if (measure == kMeasureArea) {
      float c0 = coefficients[first + t];
      in_no_ring = c0 == 0.0;
      precise float x = e1.y * e2.z - e1.z * e2.y;
      precise float y = e1.z * e2.x - e1.x * e2.z;
      precise float z = e1.x * e2.y - e1.y * e2.x;
      precise float squared = (x * x + y * y) + z * z;
      q = sqrt(squared) * c0 * frame.inverse_scale2;
    } else if (measure == kMeasurePrincipal) {
      float c0 = coefficients[first + 3u * t];
      float c1 = coefficients[first + 3u * t + 1u];
      float c2 = coefficients[first + 3u * t + 2u];
      in_no_ring = c0 == 0.0 && c1 == 0.0 && c2 == 0.0;
      precise vec3 f1 = c0 * e1;
      precise vec3 f2 = c1 * e1 + c2 * e2;
      precise float f11 = (f1.x * f1.x + f1.y * f1.y) + f1.z * f1.z;
      precise float f22 = (f2.x * f2.x + f2.y * f2.y) + f2.z * f2.z;
      precise float f12 = (f1.x * f2.x + f1.y * f2.y) + f1.z * f2.z;
      precise float halved = 0.5 * (f11 - f22);
      precise float spread = sqrt(halved * halved + f12 * f12);
      q = (0.5 * (f11 + f22) - spread) * frame.inverse_scale2;
    }
    q = q >= 0.0 ? min(q, 4.0) : 1.0;
    triangle_q[layer * frame.triangles + t] = in_no_ring ? -1.0 : q;
  }
}
