"""A mesh rebuilt to given face normals: each face shaped by itself, all faces stitched together again."""
