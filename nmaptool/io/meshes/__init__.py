"""Mesh files: OBJ, PLY, STL, OFF, GLB, glTF, 3MF, DAE, USD."""
