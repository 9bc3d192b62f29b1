"""Bodies with the exact outline of a plate: pixels inside, and a strip of triangles along the outline."""
