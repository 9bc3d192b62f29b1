"""Plates: a relief with an exact outline, a frame, holes and lettering, as one height field."""
