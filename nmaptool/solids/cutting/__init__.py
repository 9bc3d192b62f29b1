"""Parts of a relief that fit each other: where they lie, what they share, and their triangles."""
