"""Benchmarks of speed and memory: `bench.solver` for the solvers, `bench.relief` for the whole command."""
