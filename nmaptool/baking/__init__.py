"""Meshes to original, base and detail normal maps."""
