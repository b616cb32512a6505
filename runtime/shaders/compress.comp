// q of each triangle and layer.

FURROW_READ(0, uint, surface_indices);
FURROW_READ(1, float, coefficients);
FURROW_READ(2, float, positions);
FURROW_WRITE(3, float, triangle_q);

vec3 position(uint corner) {
  uint word = 3u * surface_indices[corner];
  return vec3(positions[word], positions[word + 1u], positions[word + 2u]);
}

FURROW_MAIN {
  uint t = invocationIndex();
  if (t >= frame.triangles) return;
  vec3 p0 = position(3u * t);
  precise vec3 e1 = position(3u * t + 1u) - p0;
  precise vec3 e2 = position(3u * t + 2u) - p0;
  for (uint layer = 0u; layer < frame.layers; ++layer) {
    if (!isActive(layer)) continue;
    uint measure = frame.layer[layer].measure;
    uint count = coefficientCount(measure);
    uint first = frame.layer[layer].first_coefficient + count * t;
    vec3 c = vec3(0.0, 0.0, 0.0);
    if (count > 0u) c.x = coefficients[first];
    if (count > 1u) c.y = coefficients[first + 1u];
    if (count > 2u) c.z = coefficients[first + 2u];
    bool in_no_ring = count > 0u && c.x == 0.0 && c.y == 0.0 && c.z == 0.0;
    triangle_q[layer * frame.triangles + t] = in_no_ring ? -1.0 : measureTriangle(measure, e1, e2, c);
  }
}
