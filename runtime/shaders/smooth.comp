// q of each point and layer: the mean over its ring, weighted by rest angle. A gather, so that both sides of a seam get the same bits.

FURROW_READ(0, uint, ring_offsets);
FURROW_READ(1, uint, ring_triangles);
FURROW_READ(2, uint, ring_weights);
FURROW_READ(3, float, triangle_q);
FURROW_WRITE(4, float, point_q);

FURROW_MAIN {
  uint own_point = invocationIndex();
  if (own_point >= frame.points) return;
  for (uint layer = 0u; layer < frame.layers; ++layer) {
    if (!isActive(layer)) continue;
    precise float sum = 0.0;
    precise float total = 0.0;
    for (uint i = ring_offsets[own_point]; i < ring_offsets[own_point + 1u]; ++i) {
      float value = triangle_q[layer * frame.triangles + ring_triangles[i]];
      float weight = value < 0.0 ? 0.0 : float((ring_weights[i >> 1] >> (16u * (i & 1u))) & 0xffffu);
      sum = sum + weight * value;
      total = total + weight;
    }
    point_q[layer * frame.points + own_point] = total > 0.0 ? sum / total : 1.0;
  }
}
