"""The learned filter of face normals (paper, Sec. 3.2)."""
