// Posed vertices.

FURROW_WRITE(5, float, positions);
FURROW_WRITE(6, float, normals);
FURROW_WRITE(7, float, tangents);

FURROW_MAIN {
  uint v = invocationIndex();
  if (v >= frame.vertices) return;
  PosedVertex posed = poseVertex(v);
  positions[3u * v] = posed.position.x;
  positions[3u * v + 1u] = posed.position.y;
  positions[3u * v + 2u] = posed.position.z;
  if (frame.with_normals == 0u) return;
  normals[3u * v] = posed.normal.x;
  normals[3u * v + 1u] = posed.normal.y;
  normals[3u * v + 2u] = posed.normal.z;
  tangents[4u * v] = posed.tangent.x;
  tangents[4u * v + 1u] = posed.tangent.y;
  tangents[4u * v + 2u] = posed.tangent.z;
  tangents[4u * v + 3u] = posed.tangent.w;
}
