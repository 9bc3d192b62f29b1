"""Drawing meshes: which face each pixel sees."""
