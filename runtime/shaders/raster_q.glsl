// q of a point in the layers of a slice: the sums are divided as they are fetched.

uniform sampler2DArray sums;

vec3 sliceQ(uint point, uint slice) {
  vec4 sum = texelFetch(sums, ivec3(int(point % kSumsWidth), int(point / kSumsWidth), int(slice)), 0);
  return sum.a > 0.0 ? sum.rgb / sum.a : vec3(1.0, 1.0, 1.0);
}
