// The clustered form runs many instances: work-group row y is instance instances[y].
FURROW_READ(8, FrameConstants, frames);
FURROW_READ(9, uint, instances);

FURROW_GLOBAL uint instance;
#define frame frames[instance]
