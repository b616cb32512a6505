layout(location = 0) out vec4 color;

void main() {
  float rise = gl_FragCoord.y / scene.size.y;
  vec3 grey = mix(vec3(0.013, 0.0135, 0.0145), vec3(0.034, 0.036, 0.04), smoothstep(0.0, 1.0, rise));
  // Half a step of noise, so that 8 bits show no bands.
  float noise = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715)))) - 0.5;
  color = vec4(grey * (1.0 + noise * 0.03), 1.0);
}
