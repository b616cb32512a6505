// The thin layer between furrow's shader texts and the shading language: compute shaders in HLSL. Storage buffers
// that are read are t registers, that are written u registers; uniform buffers are b registers.
#define FURROW_HLSL
#define FURROW_CONSTANT static const uint
#define FURROW_READ(slot, type, name) StructuredBuffer<type> name : register(t##slot)
#define FURROW_WRITE(slot, type, name) RWStructuredBuffer<type> name : register(u##slot)
#define FURROW_UPDATE(slot, type, name) RWStructuredBuffer<type> name : register(u##slot)
#define FURROW_UNIFORM(slot, type, name) cbuffer name##_block : register(b##slot) { type name; }
#define FURROW_AT(name, index) name[index]
#define FURROW_SHARED groupshared
#define FURROW_GLOBAL static
#define FURROW_SYNC GroupMemoryBarrierWithGroupSync()
#define FURROW_MAIN void furrowMain()
#define vec3 float3
#define vec4 float4
#define roundEven round
#define uintBitsToFloat asfloat

static uint3 furrow_group;
static uint furrow_thread;
void furrowMain();

[numthreads(128, 1, 1)]  // kGroupSize
void main(uint3 group : SV_GroupID, uint3 thread : SV_GroupThreadID) {
  furrow_group = group;
  furrow_thread = thread.x;
  furrowMain();
}
