int signed24(uint word) { return int(word << 8) >> 8; }
int signed16(uint word) { return int(word << 16) >> 16; }
int signed8(uint word) { return int(word << 24) >> 24; }

bool isActive(uint layer) { return (frame.active_layers >> layer & 1u) != 0u; }
