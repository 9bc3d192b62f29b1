"""Triangles to files, part by part, and back to check them."""
