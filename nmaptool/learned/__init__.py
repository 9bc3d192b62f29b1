"""A filter of normals learned from examples: networks in a cascade, each for one kind of neighbourhood."""
