"""Solve a system by overlapping tiles and a coarse grid, so that only one tile and the coarse grid are in memory."""
