"""Separate base and detail, on meshes and in normal maps; learned filters."""
