// The staged and the raster form run one instance.
FURROW_UNIFORM(0, FrameConstants, frame);

const uint instance = 0u;
