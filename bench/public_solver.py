"""A public normal-integration solver compared with ours, if it is installed: ``pip install dbini-torch torch``.

dbini-torch is bilateral normal integration (Cao et al., ECCV 2022) for PyTorch. With k = 0 its two sides have equal
weights and one step is a linear least-squares problem like ours, on pixels instead of their corners. Run as a program,
this module is the child process that measures it.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import time

from bench.runs import Job, child, measure
from bench.systems import Case

PACKAGE = "dbini_torch"
_CASE = Case(256, 256, beta=0.0)
_TOLERANCE = 1e-6


def compare(limit: float, spend: float) -> str:
    """One line with its time and ours on the same motif."""
    if importlib.util.find_spec(PACKAGE) is None:
        return "dbini-torch, a public normal-integration solver, is not installed here."
    try:
        done = child("bench.public_solver", limit)
    except subprocess.TimeoutExpired:
        return f"dbini-torch, a public normal-integration solver, takes more than {limit:.0f} s for {_CASE}."
    if done.returncode:
        return f"dbini-torch, a public normal-integration solver, fails: {done.stderr.splitlines()[-1]}"
    seconds = float(json.loads(done.stdout.splitlines()[-1])["seconds"])
    line = f"dbini-torch, a public normal-integration solver, takes {seconds:.2f} s for {_CASE}, to {_TOLERANCE:g}"
    outcomes = measure([Job(_CASE, name, (_TOLERANCE,)) for name in ("multigrid", "amg")], limit, spend)
    for name, outcome in zip(("multigrid", "amg"), outcomes, strict=True):
        total = outcome.total(0)
        if total is not None:
            return f"{line}; {name} {total:.3f} s, including setup: {seconds / total:.0f} times as fast."
    return f"{line}."


def main() -> None:
    """The child process: seconds of one linear step on the normals of the motif."""
    import torch
    from dbini_torch import bilateral_normal_integration

    from bench.maps import scene

    def solve(side: int) -> float:
        made = scene(side, side)
        normals = torch.from_numpy(made.normals.astype("float64").transpose(2, 0, 1).copy())
        motif = torch.from_numpy(made.motif)
        started = time.perf_counter()
        bilateral_normal_integration(normals, motif, k=0, max_iter=1, cg_max_iter=100_000, cg_rtol=_TOLERANCE)
        return time.perf_counter() - started

    solve(32)
    print(json.dumps({"seconds": solve(_CASE.rows)}))


if __name__ == "__main__":
    main()
