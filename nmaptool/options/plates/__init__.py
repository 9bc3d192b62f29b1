"""Options of plates: their shape, frame and lettering, and the machines that make them."""
