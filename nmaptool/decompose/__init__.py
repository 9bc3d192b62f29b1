"""A field of normals split into base and detail: rolling guidance on a mesh or a map, and a mixture threshold."""
