"""Compare methods with each other."""
