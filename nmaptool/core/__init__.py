"""Shared by all packages: errors, units, arrays, threads, memory, grids and vectors."""
