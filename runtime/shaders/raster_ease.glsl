// Where each vertex's weights are on their way to their targets.

FURROW_READ(3, float, state);

flat out float state0;
flat out float state1;
flat out float state2;
flat out float state3;
flat out float state4;
flat out float state5;
flat out float state6;
flat out float state7;
flat out float state8;
flat out float state9;
flat out float state10;
flat out float state11;
flat out float state12;
flat out float state13;
flat out float state14;
flat out float state15;

float next(uint layer) {
  if (layer >= frame.layers) return 0.0;
  uint v = uint(gl_VertexID);
  float target = isActive(layer) ? weightOf(v, layer, pointQ(v, layer)) : 0.0;
  return eased(layer, target, FURROW_AT(state, stateOf(v, layer)));
}

void main() {
  state0 = next(0u);
  state1 = next(1u);
  state2 = next(2u);
  state3 = next(3u);
  state4 = next(4u);
  state5 = next(5u);
  state6 = next(6u);
  state7 = next(7u);
  state8 = next(8u);
  state9 = next(9u);
  state10 = next(10u);
  state11 = next(11u);
  state12 = next(12u);
  state13 = next(13u);
  state14 = next(14u);
  state15 = next(15u);
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
