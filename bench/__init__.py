"""Speed and memory, measured in one run: `bench.solver` for the solvers, `bench.relief` for the whole command."""
