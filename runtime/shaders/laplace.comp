// A Laplacian step of q of each point and layer (LaplaceJob).

FURROW_READ(0, uint, ring_offsets);
FURROW_READ(1, uint, ring_triangles);
FURROW_READ(2, uint, ring_weights);
FURROW_READ(3, float, triangle_q);
FURROW_READ(4, uint, surface_indices);
FURROW_READ(5, uint, vertex_point);
FURROW_READ(6, float, point_q);
FURROW_WRITE(7, float, smoothed_q);

FURROW_MAIN {
  uint own_point = invocationIndex();
  if (own_point >= frame.points) return;
  for (uint layer = 0u; layer < frame.layers; ++layer) {
    if (!isActive(layer)) continue;
    uint points = layer * frame.points;
    float own = point_q[points + own_point];
    precise float sum = 0.0;
    precise float total = 0.0;
    for (uint i = ring_offsets[own_point]; i < ring_offsets[own_point + 1u]; ++i) {
      uint t = ring_triangles[i];
      if (triangle_q[layer * frame.triangles + t] < 0.0) continue;
      uint a = vertex_point[surface_indices[3u * t]];
      uint b = vertex_point[surface_indices[3u * t + 1u]];
      uint c = vertex_point[surface_indices[3u * t + 2u]];
      float qa = point_q[points + a];
      float qb = point_q[points + b];
      float qc = point_q[points + c];
      precise float others = 0.5 * (own_point == a ? qb + qc : own_point == b ? qc + qa : qa + qb);
      precise float value = own + frame.laplace_rate * (others - own);
      float weight = float((ring_weights[i >> 1] >> (16u * (i & 1u))) & 0xffffu);
      sum = sum + weight * value;
      total = total + weight;
    }
    smoothed_q[points + own_point] = total > 0.0 ? sum / total : own;
  }
}
