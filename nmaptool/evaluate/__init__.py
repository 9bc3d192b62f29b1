"""Methods compared with each other."""
