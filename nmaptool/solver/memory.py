"""Estimate the memory that a solve needs before any of it is allocated."""

from __future__ import annotations

from nmaptool.core.errors import LimitError
from nmaptool.core.memory import available_bytes
from nmaptool.core.units import memory_text

# Measured at the peak of set-up and solve, excluding weight, beta, held and the right-hand side: bytes per vertex, and
# bytes per unknown vertex. They include the float64 heights, the residual in the method's precision, the map of
# unknowns and the data on islands. With multigrid, noise and mazes take up to a third more.
BYTES_PER_VERTEX = {"dct": 16, "multigrid": 65, "float64 multigrid": 120, "amg": 16}
BYTES_PER_UNKNOWN = {"dct": 0, "multigrid": 0, "float64 multigrid": 0, "amg": 560}
# the bands, one per thread, and what the libraries keep
_BESIDE = 16_000_000


def kind_of(method: str, has_wide_weights: bool) -> str:
    """Return the key of a method in the tables above: multigrid uses float64 if the weights span a wide range."""
    return "float64 multigrid" if method == "multigrid" and has_wide_weights else method


def estimate(system_shape: tuple[int, int], unknowns: int, method: str) -> int:
    """Return the peak memory in bytes of `nmaptool.solver.prepare` and one solve.

    Parameters
    ----------
    system_shape : (int, int)
        Rows and columns of faces: H, W.
    unknowns : int
    method : {"dct", "multigrid", "float64 multigrid", "amg"}

    Examples
    --------
    >>> estimate((4096, 4096), 4097**2, "dct") // 10**6
    284
    """
    vertices = (system_shape[0] + 1) * (system_shape[1] + 1)
    return vertices * BYTES_PER_VERTEX[method] + unknowns * BYTES_PER_UNKNOWN[method] + _BESIDE


def plan(system_shape: tuple[int, int], unknowns: int, method: str, limit_bytes: int | None) -> int:
    """Return the estimate in bytes, or raise an error if it exceeds the limit.

    Parameters
    ----------
    system_shape, unknowns, method
        As for `estimate`.
    limit_bytes : int or None
        None: the memory that is free on the machine.

    Raises
    ------
    LimitError
        If it exceeds the limit; the message says how much is needed, how much is available, and what to do.
    """
    needed = estimate(system_shape, unknowns, method)
    allowed = available_bytes() if limit_bytes is None else limit_bytes
    if allowed is None or needed <= allowed:
        return needed
    rows, cols = system_shape
    remedies = "make the picture smaller" + (", use `solver='auto'`" if method == "amg" else "")
    if limit_bytes is None:
        found, last = f"{memory_text(allowed)} are free", "close other programs"
    else:
        # 5% more, so that the rounded number in the message is enough
        found, last = f"`memory_limit` allows {memory_text(allowed)}", f"raise it to {memory_text(needed * 21 // 20)}"
    raise LimitError(
        f"{cols} x {rows} px to solve: the {method} solver needs about {memory_text(needed)} of memory, {found}; "
        f"{remedies}, or {last}"
    )
