// The clustered frame: a work-group poses, measures, gathers and answers one cluster of one instance. The same
// numbers as the staged form (src/cluster_frame.cpp on the CPU).

FURROW_READ(2, uint, vertex_point);
FURROW_READ(5, uint, table);
FURROW_READ(7, uint, data);
FURROW_UPDATE(10, float, positions);
FURROW_WRITE(11, float, normals);
FURROW_WRITE(12, float, tangents);
FURROW_UPDATE(13, float, state);
FURROW_WRITE(14, uint, weights);
FURROW_WRITE(15, float, point_q);

FURROW_SHARED float shared_positions[3u * kClusterSlotLimit];
// Morphed normals while vertices are posed, q of the triangles after that.
FURROW_SHARED float shared_scratch[kClusterTriangleLimit];
FURROW_SHARED float shared_q[2u * kClusterPointLimit];  // of two layers

uint half16(uint first_word, uint index) { return (data[first_word + index / 2u] >> (16u * (index & 1u))) & 0xffffu; }

vec3 slotPosition(uint slot) {
  return vec3(shared_positions[3u * slot], shared_positions[3u * slot + 1u], shared_positions[3u * slot + 2u]);
}

void addMorphs(uint begin, uint end, uint slots, uint vertices) {
  for (uint run = begin; run < end; run += kRunWords) {
    uint morph = table[run];
    float step = positionStep(morph);
    float normal_step = normalStep(morph);
    if (step == 0.0 && normal_step == 0.0) continue;
    FURROW_SYNC;
    for (uint word = table[run + 1u] + kEntryWords * furrow_thread; word < table[run + 2u]; word += kEntryWords * kGroupSize) {
      uint at = 3u * table[word + 3u];
      if (at >= 3u * slots) break;  // slots ascend
      uint dx = table[word];
      uint dy = table[word + 1u];
      uint dz = table[word + 2u];
      precise float x = shared_positions[at] + step * float(signed24(dx));
      precise float y = shared_positions[at + 1u] + step * float(signed24(dy));
      precise float z = shared_positions[at + 2u] + step * float(signed24(dz));
      shared_positions[at] = x;
      shared_positions[at + 1u] = y;
      shared_positions[at + 2u] = z;
      if (frame.with_normals == 0u || at >= 3u * vertices) continue;
      shared_scratch[at] += normal_step * float(signed8(dx >> 24));
      shared_scratch[at + 1u] += normal_step * float(signed8(dy >> 24));
      shared_scratch[at + 2u] += normal_step * float(signed8(dz >> 24));
    }
  }
  FURROW_SYNC;
}

// The halo is for measuring alone.
void poseCluster(uint cluster, bool with_halo) {
  uint vertices = table[cluster + kClusterVertices];
  uint slots = with_halo ? table[cluster + kClusterSlots] : vertices;
  uint slot_vertex = table[cluster + kClusterSlotVertex];
  uint first = instance * frame.vertices;
  if (frame.posed_by_host != 0u) {
    if (!with_halo) return;
    for (uint s = furrow_thread; s < slots; s += kGroupSize) {
      uint at = 3u * (first + data[slot_vertex + s]);
      for (uint c = 0u; c < 3u; ++c) shared_positions[3u * s + c] = positions[at + c];
    }
    FURROW_SYNC;
    return;
  }
  bool with_normals = frame.with_normals != 0u;
  for (uint s = furrow_thread; s < slots; s += kGroupSize) {
    uint v = data[slot_vertex + s];
    for (uint c = 0u; c < 3u; ++c) shared_positions[3u * s + c] = restWord(3u * v + c);
    if (with_normals && s < vertices)
      for (uint c = 0u; c < 3u; ++c) shared_scratch[3u * s + c] = restWord(restFrame(v) + c);
  }
  addMorphs(table[cluster + kClusterRuns], table[cluster + kClusterRunsEnd], slots, vertices);
  for (uint s = furrow_thread; s < slots; s += kGroupSize) {
    uint v = data[slot_vertex + s];
    bool owned = s < vertices;
    bool with_frame = with_normals && owned;
    vec3 n = vec3(0.0, 0.0, 0.0);
    if (with_frame) n = vec3(shared_scratch[3u * s], shared_scratch[3u * s + 1u], shared_scratch[3u * s + 2u]);
    PosedVertex posed = skin(v, slotPosition(s), n, with_frame);
    shared_positions[3u * s] = posed.position.x;
    shared_positions[3u * s + 1u] = posed.position.y;
    shared_positions[3u * s + 2u] = posed.position.z;
    if (!owned) continue;
    uint at = first + v;
    positions[3u * at] = posed.position.x;
    positions[3u * at + 1u] = posed.position.y;
    positions[3u * at + 2u] = posed.position.z;
    if (!with_frame) continue;
    normals[3u * at] = posed.normal.x;
    normals[3u * at + 1u] = posed.normal.y;
    normals[3u * at + 2u] = posed.normal.z;
    tangents[4u * at] = posed.tangent.x;
    tangents[4u * at + 1u] = posed.tangent.y;
    tangents[4u * at + 2u] = posed.tangent.z;
    tangents[4u * at + 3u] = posed.tangent.w;
  }
  FURROW_SYNC;
}

// q of the triangles, `coefficients` lying by lanes of 16.
void measureCluster(uint cluster, uint layer, uint coefficients) {
  uint triangles = table[cluster + kClusterTriangles];
  uint corners = table[cluster + kClusterCorners];
  uint measure = frame.layer[layer].measure;
  uint count = coefficientCount(measure);
  for (uint t = furrow_thread; t < triangles; t += kGroupSize) {
    vec3 p0 = slotPosition(half16(corners, 3u * t) / 4u);
    precise vec3 e1 = slotPosition(half16(corners, 3u * t + 1u) / 4u) - p0;
    precise vec3 e2 = slotPosition(half16(corners, 3u * t + 2u) / 4u) - p0;
    uint word = coefficients + t / 16u * 16u * count + t % 16u;
    vec3 c = vec3(uintBitsToFloat(data[word]), 0.0, 0.0);
    if (count > 1u) c.y = uintBitsToFloat(data[word + 16u]);
    if (count > 2u) c.z = uintBitsToFloat(data[word + 32u]);
    bool in_no_ring = c.x == 0.0 && c.y == 0.0 && c.z == 0.0;
    shared_scratch[t] = in_no_ring ? 0.0 : measureTriangle(measure, e1, e2, c);
  }
  FURROW_SYNC;
}

// q of a point: rings of 8 points lie side by side, a step being 8 triangles and then their 8 weights.
float gather(uint cluster, uint layer, uint coefficients, uint own_point) {
  uint chunk = table[cluster + kClusterChunks] + own_point / 8u;
  uint lane = own_point % 8u;
  uint totals = coefficients + table[cluster + kClusterTriangles] * coefficientCount(frame.layer[layer].measure);
  precise float total = float(half16(totals, own_point));
  precise float sum = 0.0;
  for (uint step = data[chunk]; step < data[chunk + 1u]; step += 8u)
    sum = sum + float(half16(step, 8u + lane)) * shared_scratch[half16(step, lane)];
  return total > 0.0 ? sum / total : 1.0;
}

uint weight16(uint cluster, uint layer, uint v, uint own_point) {
  if (layer >= frame.layers) return 0u;
  float w = isActive(layer) ? weightOf(v, layer, shared_q[(layer & 1u) * kClusterPointLimit + own_point]) : 0.0;
  if (frame.with_ease != 0u) {
    uint at = (instance * frame.vertices + v) * ((frame.layers + 1u) & ~1u) + layer;
    w = eased(layer, w, state[at]);
    state[at] = w;
  }
  return stored(w);
}

FURROW_MAIN {
  instance = instances[furrow_group.y];
  uint cluster = furrow_group.x * (kClusterWords + frame.layers);
  uint measured_layers = table[cluster + kClusterCovered] & frame.active_layers;
  poseCluster(cluster, measured_layers != 0u);
  uint points = table[cluster + kClusterPoints];
  uint vertices = table[cluster + kClusterVertices];
  uint pairs = (frame.layers + 1u) / 2u;
  for (uint pair = 0u; pair < pairs; ++pair) {
    for (uint layer = 2u * pair; layer < 2u * pair + 2u && layer < frame.layers; ++layer) {
      uint coefficients = table[cluster + kClusterWords + layer];
      bool measured = (measured_layers >> layer & 1u) != 0u;
      if (measured) measureCluster(cluster, layer, coefficients);
      for (uint p = furrow_thread; p < points; p += kGroupSize) {
        float q = 1.0;
        if (measured) q = gather(cluster, layer, coefficients, p);
        shared_q[(layer & 1u) * kClusterPointLimit + p] = q;
        if (frame.with_point_q == 0u) continue;
        uint own_point = vertex_point[data[table[cluster + kClusterSlotVertex] + p]];
        point_q[(instance * frame.layers + layer) * frame.points + own_point] = q;
      }
      FURROW_SYNC;
    }
    for (uint s = furrow_thread; s < vertices; s += kGroupSize) {
      uint v = data[table[cluster + kClusterSlotVertex] + s];
      uint own_point = s;
      if (s >= points) own_point = half16(table[cluster + kClusterExtraPoint], s - points);
      weights[(instance * frame.vertices + v) * pairs + pair] =
          weight16(cluster, 2u * pair, v, own_point) | (weight16(cluster, 2u * pair + 1u, v, own_point) << 16);
    }
    FURROW_SYNC;
  }
}
