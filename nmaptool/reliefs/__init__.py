"""Normal maps to reliefs: targets, heights, exact millimetres."""
