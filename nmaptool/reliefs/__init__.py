"""Convert normal maps to reliefs: targets, heights, exact millimetres."""
