"""Base and detail told apart, on meshes and in normal maps; learned filters."""
