// Weights of each vertex, two layers a word.

FURROW_READ(2, float, point_q);
FURROW_WRITE(3, uint, weights);

uint weight16(uint v, uint layer) {
  return layer < frame.layers ? weightOf(v, layer, point_q[layer * frame.points + vertex_point[v]]) : 0u;
}

void main() {
  uint v = invocationIndex();
  if (v >= frame.vertices) return;
  uint pairs = (frame.layers + 1u) / 2u;
  for (uint pair = 0u; pair < pairs; ++pair)
    weights[v * pairs + pair] = weight16(v, 2u * pair) | (weight16(v, 2u * pair + 1u) << 16);
}
