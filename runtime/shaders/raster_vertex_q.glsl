// q of a vertex's point in a layer.

FURROW_READ(0, uint, vertex_point);

float pointQ(uint v, uint layer) {
  if (frame.layer[layer].slice == kNoLayer) return 1.0;
  return sliceQ(FURROW_AT(vertex_point, v), frame.layer[layer].slice)[frame.layer[layer].channel];
}
