"""Results to files, all of them or none."""
