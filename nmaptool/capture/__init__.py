"""From a mesh to what each pixel of a camera sees of it."""
