/* Reads a mesh from the server's bytes; see nmaptool.studio.display_mesh. */

/** Header, convex hull, positions around the header's origin, and triangles. */
export function decodeMesh(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let at = 4 + length;
  const corners = new Float64Array(bytes, at, 3 * header.corners);
  at += 24 * header.corners;
  const positions = new Float32Array(bytes, at, 3 * header.vertices);
  at += 12 * header.vertices;
  return { header, corners, positions, triangles: new Uint32Array(bytes, at, 3 * header.triangles) };
}
