"""Recipe files, and the pictures that they name."""
