"""Write results to files, all of them or none."""
