"""The benchmarks that `python -m bench` runs, in this order: one line for each module of this package."""

# name, and arguments that keep a run of all to less than an hour
MODULES: dict[str, tuple[str, ...]] = {
    "quick": (),
    "kernels": (),
    "solver": ("--sizes", "1024", "4096", "8192", "--limit", "45", "--spend", "1"),
    "crossover": ("--sizes", "64", "256", "1024", "--limit", "15"),
    "session": (),
    "studio": (),
    "relief": (),
    "bake": (),
    "learned": (),
    "reconstruct": (),
    "compose": (),
    "solids": (),
    "plates": (),
    "tiled": ("--side", "8192"),
    "sweeps": (),
    "batch": (),
    "files": (),
    "compression": (),
}
QUICK = ("quick",)
