"""What every room stands on: errors, units, arrays, threads, memory, grids and vectors."""
