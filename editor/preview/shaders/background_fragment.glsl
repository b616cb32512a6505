layout(location = 0) out vec4 color;

void main() { color = vec4(backgroundColor(gl_FragCoord.xy, scene.size.y), 1.0); }
