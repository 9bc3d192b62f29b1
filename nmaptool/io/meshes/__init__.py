"""Mesh files: OBJ, PLY, STL, OFF, GLB, glTF."""
