"""Edit normal maps as vectors: blend, place, transform, convert; recipes."""
