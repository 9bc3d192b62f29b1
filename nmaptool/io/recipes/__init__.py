"""Read recipe files and the pictures that they name."""
