"""Lettering: text shaped with a font and laid out along lines and curves, as closed curves in millimetres."""
