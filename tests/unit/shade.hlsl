// A pixel shader of an engine in HLSL that uses furrow_shade.glsl; a test compiles it.
#define FURROW_HLSL
Texture2DArray normal_maps, shading_maps, mask_maps;
SamplerState repeat_all;
cbuffer Material { float4 windows[32]; uint4 slices[16]; uint layers; }
static float4 interpolated[4];
static float2 uv_dx, uv_dy;
#define FURROW_WINDOW(slice) windows[slice]
#define FURROW_NORMAL(at, slice, zoom) normal_maps.SampleGrad(repeat_all, float3(at, slice), uv_dx * zoom, uv_dy * zoom).xy
#define FURROW_SHADING(at, slice, zoom) shading_maps.SampleGrad(repeat_all, float3(at, slice), uv_dx * zoom, uv_dy * zoom).x
#define FURROW_MASK(uv, slice) mask_maps.SampleGrad(repeat_all, float3(uv, slice), uv_dx, uv_dy)
#define FURROW_WEIGHT(layer) interpolated[layer / 4u][layer % 4u]
#define FURROW_SLICES(layer) slices[layer]
#include "furrow_shade.glsl"

float4 main(float2 uv : TEXCOORD0, float4 weights[4] : TEXCOORD1) : SV_Target {
  interpolated = weights;
  uv_dx = ddx(uv);
  uv_dy = ddy(uv);
  FurrowSurface surface = furrowSurface(float3(0.0, 0.0, 1.0), uv, layers);
  return float4(surface.normal * surface.cavity, furrowRoughness(0.5, surface.variance));
}
