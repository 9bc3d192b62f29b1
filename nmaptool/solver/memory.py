"""Memory that solving takes, known before any of it is asked for."""

from __future__ import annotations

from nmaptool.core.errors import LimitError
from nmaptool.core.memory import available_bytes
from nmaptool.core.units import memory_text

# Measured at the peak of set-up and solve, beyond weight, beta, held and the right-hand side: bytes a vertex, and bytes
# a vertex to be solved for. Heights in float64, the residual in the method's precision, the map of unknowns and the
# islands' book-keeping are in them. Noise and mazes take up to a third more of multigrid.
BYTES_PER_VERTEX = {"dct": 16, "multigrid": 65, "float64 multigrid": 120, "amg": 16}
BYTES_PER_UNKNOWN = {"dct": 0, "multigrid": 0, "float64 multigrid": 0, "amg": 560}
# room for bands, one for each thread, and what the libraries keep
_BESIDE = 16_000_000


def kind_of(method: str, has_wide_weights: bool) -> str:
    """What the plan knows a method by: multigrid holds float64 for weights that span much."""
    return "float64 multigrid" if method == "multigrid" and has_wide_weights else method


def estimate(system_shape: tuple[int, int], unknowns: int, method: str) -> int:
    """Bytes that `nmaptool.solver.prepare` and one solve take at their peak.

    Parameters
    ----------
    system_shape : (int, int)
        Of the faces: H, W.
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
    """The estimate, if it fits.

    Parameters
    ----------
    system_shape, unknowns, method
        As for `estimate`.
    limit_bytes : int or None
        None: what the machine has to give.

    Raises
    ------
    LimitError
        If it does not fit: how much is needed, how much there is, and what to do.
    """
    needed = estimate(system_shape, unknowns, method)
    allowed = available_bytes() if limit_bytes is None else limit_bytes
    if allowed is None or needed <= allowed:
        return needed
    rows, cols = system_shape
    remedies = "make the picture smaller, crop it to the motif" + (", use `solver='auto'`" if method == "amg" else "")
    if limit_bytes is None:
        found, last = f"{memory_text(allowed)} are free", "close other programs"
    else:
        # a little more, so that it is enough as it is printed
        found, last = f"`memory_limit` allows {memory_text(allowed)}", f"raise it to {memory_text(needed * 21 // 20)}"
    raise LimitError(
        f"{cols} x {rows} px: the {method} solver needs about {memory_text(needed)} of memory, {found}; "
        f"{remedies}, or {last}"
    )
