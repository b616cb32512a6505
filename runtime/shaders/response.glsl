// The weight of a vertex from q, as the low 16 bits of a word (snorm16).

FURROW_READ(0, uint, vertex_point);
FURROW_READ(1, uint, bias);

float intensity(float log_alpha, float log_lambda, float beta) {
  return max(0.0, 1.0 - 2.0 / (1.0 + exp2(clamp(beta * (log_alpha - log_lambda), -126.0, 126.0))));
}

uint weightOf(uint v, uint layer, float point_q) {
  float q = max(point_q, 1.0 / 64.0);
  float w = 1.0 - q;
  if (frame.layer[layer].curve == kCurveLarsson) {
    float log_alpha = -log2(q);
    w = intensity(log_alpha, log2(frame.layer[layer].lambda), frame.layer[layer].beta) -
        intensity(-log_alpha, log2(frame.layer[layer].stretch_lambda), frame.layer[layer].stretch_beta);
  }
  if (frame.with_bias != 0u) {
    uint pairs = (frame.layers + 1u) / 2u;
    w = w + float(signed16(FURROW_AT(bias, v * pairs + layer / 2u) >> (16u * (layer & 1u)))) * (1.0 / 32767.0);
  }
  return uint(int(roundEven(clamp(w + frame.layer[layer].region, -1.0, 1.0) * 32767.0))) & 0xffffu;
}
