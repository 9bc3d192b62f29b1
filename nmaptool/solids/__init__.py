"""Height fields to triangles: surfaces, closed solids, outlines, fewer triangles within an error."""
