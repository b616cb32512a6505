// Weights of each vertex, two layers a word.

FURROW_READ(0, uint, vertex_point);
FURROW_READ(2, float, point_q);
FURROW_WRITE(3, uint, weights);
FURROW_UPDATE(4, float, state);

uint weight16(uint v, uint layer) {
  if (layer >= frame.layers) return 0u;
  float w = isActive(layer) ? weightOf(v, layer, point_q[layer * frame.points + vertex_point[v]]) : 0.0;
  if (frame.with_ease != 0u) {
    uint at = stateOf(v, layer);
    w = eased(layer, w, state[at]);
    state[at] = w;
  }
  return stored(w);
}

FURROW_MAIN {
  uint v = invocationIndex();
  if (v >= frame.vertices) return;
  uint pairs = (frame.layers + 1u) / 2u;
  for (uint pair = 0u; pair < pairs; ++pair)
    weights[v * pairs + pair] = weight16(v, 2u * pair) | (weight16(v, 2u * pair + 1u) << 16);
}
