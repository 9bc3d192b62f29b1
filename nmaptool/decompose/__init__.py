"""Taking normals apart: the base left when detail is smoothed away, and the detail that it leaves behind."""
