layout(location = 0) in vec3 position;
layout(location = 3) in vec2 uv;

out vec2 place;

void main() {
  place = uv;
  gl_Position = vec4((scene.shadow * vec4(position, 1.0)).xyz * 2.0 - 1.0, 1.0);
}
