"""Normal maps as layers for image editors, and back."""
