"""The benchmarks that `python -m bench` runs, in this order: one line for each module of this package."""

MODULES = (
    "quick",
    "kernels",
    "solver",
    "crossover",
    "session",
    "relief",
    "bake",
    "learned",
    "reconstruct",
    "compose",
    "solids",
)
QUICK = ("quick",)
