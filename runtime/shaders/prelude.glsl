// The thin layer between furrow's compute shaders and the shading language.
#define FURROW_READ(slot, type, name) layout(std430, binding = slot) restrict readonly buffer name##_block { type name[]; }
#define FURROW_WRITE(slot, type, name) layout(std430, binding = slot) restrict writeonly buffer name##_block { type name[]; }

layout(local_size_x = 128) in;  // kGroupSize
layout(std140, binding = 0) uniform frame_block { FrameConstants frame; };

// Index of this invocation; work-groups are laid out in two dimensions because one holds 65535 at most.
uint invocationIndex() { return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * kGroupSize + gl_LocalInvocationID.x; }

int signed24(uint word) { return int(word << 8) >> 8; }
int signed16(uint word) { return int(word << 16) >> 16; }
int signed8(uint word) { return int(word << 24) >> 24; }
