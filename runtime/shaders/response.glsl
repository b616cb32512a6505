// The weight of a vertex from q.

FURROW_READ(6, uint, bias);

float intensity(float log_alpha, float log_lambda, float beta) {
  return max(0.0, 1.0 - 2.0 / (1.0 + exp2(clamp(beta * (log_alpha - log_lambda), -126.0, 126.0))));
}

int toSnorm16(float w) { return int(roundEven(clamp(w, -1.0, 1.0) * 32767.0)); }

// In snorm16's steps.
float weightOf(uint v, uint layer, float point_q) {
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
  return float(toSnorm16(w + frame.layer[layer].region)) * (1.0 / 32767.0);
}

// Where the state of a vertex's layer is.
uint stateOf(uint v, uint layer) { return v * ((frame.layers + 1u) & ~1u) + layer; }

// A weight on its way to `target` from where it was (EaseJob).
float eased(uint layer, float target, float state) {
  float step = abs(target) > abs(state) ? frame.layer[layer].attack : frame.layer[layer].release;
  return step == 1.0 ? target : state + (target - state) * step;
}

// As it is stored, in the low 16 bits.
uint stored(float w) { return uint(toSnorm16(w * frame.fade)) & 0xffffu; }
