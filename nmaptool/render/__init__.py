"""Render meshes: the face that each pixel sees."""
