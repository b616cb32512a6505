// The state of the next frame: what cannot be read while it is captured is captured beside it and copied.

FURROW_READ(0, float, next_state);
flat out float kept;

void main() {
  kept = FURROW_AT(next_state, gl_VertexID);
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
