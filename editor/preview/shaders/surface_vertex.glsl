layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec2 uv;
layout(location = 4) in vec4 weights[4];
layout(location = 8) in vec4 masks[4];
layout(location = 12) in vec4 value;  // of the view; of beauty: the colour, see AssetView::colors

out Surface {
  vec3 position;
  vec3 normal;
  vec4 tangent;
  vec2 uv;
  vec4 weights[4];  // multiplied by the vertex's masks unless the part has a mask texture
  vec4 masks[4];
  vec4 value;
} vertex;

void main() {
  vertex.position = position;
  vertex.normal = normal;
  vertex.tangent = tangent;
  vertex.uv = uv;
  vertex.value = value;
  bool masked = material.with_masks == 0u && kView == kViewBeauty;
  for (int i = 0; i < 4; ++i) {
    vertex.weights[i] = masked ? weights[i] * masks[i] : weights[i];
    vertex.masks[i] = masks[i];
  }
  gl_Position = scene.view_projection * vec4(position, 1.0);
}
