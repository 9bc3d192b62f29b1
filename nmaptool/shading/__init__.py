"""Pictures of reliefs in a material, from their heights, without OpenGL."""
