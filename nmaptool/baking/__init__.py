"""Render meshes as original, base and detail normal maps."""
