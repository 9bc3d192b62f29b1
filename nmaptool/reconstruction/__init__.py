"""Rebuild a mesh to given face normals: shape each face separately, then stitch all faces together."""
