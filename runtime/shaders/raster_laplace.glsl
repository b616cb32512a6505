// A Laplacian step: every corner goes towards the other two (LaplaceJob).

flat in vec3 corner_q[];

void main() {
  for (int i = 0; i < 3; ++i) {
    vec3 own = corner_q[i];
    precise vec3 others = 0.5 * (corner_q[(i + 1) % 3] + corner_q[(i + 2) % 3]);
    precise vec3 q = own + frame.laplace_rate * (others - own);
    addCorner(i, q);
  }
}
