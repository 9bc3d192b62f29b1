"""Interpolation that follows the couplings, after Dendy's black-box multigrid (J. Comput. Phys. 48, 1982).

A vertex between two coarse ones is interpolated from each in proportion to its coupling to that side, so nothing is
interpolated across a gap or a jump of the weights. A vertex that is only weakly coupled to the coarse ones next to it
(on a thin branch that runs between them) is left out: it becomes an off-grid vertex, a separate unknown on all coarser
levels.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nmaptool.kernels.coarsening.split import LINKS, Split
from nmaptool.kernels.grid_twins import Values, add_product

# a vertex becomes off-grid if its coarse neighbours have less than this share of its couplings
HELD_SHARE = 0.4
# a side counts if its nearest vertex has at least this share of the side's couplings
_DIRECT_SHARE = 0.1
# the interpolation ignores ties to fixed heights below this share of the diagonal
_FELT_TIE = 0.02
_TINY = 1e-37

# a side: its name and its couplings, the one to its middle vertex first
Sides = tuple[str, tuple[tuple[str, int, int], ...]]
_BESIDE: tuple[Sides, Sides] = (
    ("w", (("e_o", 0, 0), ("se_u", -1, 0), ("sw_b", 0, 0))),
    ("e", (("e_b", 0, 0), ("se_b", 0, 0), ("sw_u", -1, 1))),
)
_UNDER: tuple[Sides, Sides] = (
    ("n", (("s_o", 0, 0), ("se_b", 0, -1), ("sw_b", 0, 0))),
    ("s", (("s_u", 0, 0), ("se_u", 0, 0), ("sw_u", 0, 0))),
)

WEIGHTS = ("b_w", "b_e", "u_n", "u_s", "d_nw", "d_ne", "d_sw", "d_se")


def interpolate(split: Split) -> None:
    """Add the weights (`WEIGHTS`), 1 minus their sums ("lack_b", "lack_u", "lack_d") and the off-grid vertices.

    Expects the couplings and, per kind, "tie" (coupling to fixed heights) and "out" (coupling to off-grid vertices).
    Works on a band and one more row on either side. Off-grid vertices are 1 in "stray_b", "stray_u", "stray_d"; the
    weights of off-grid couplings are the couplings times "scale_b", "scale_u" and "scale_d".
    """
    split.reach(1)
    for kind in "bud":
        total = split.keep(f"sum_{kind}")
        for _, _, _, name, down, across in LINKS[kind]:
            total += split(name, down, across)
        total += split(f"out_{kind}")
    _between(split, "b", *_BESIDE)
    _between(split, "u", *_UNDER)
    _diagonal(split)


def _side(split: Split, near: tuple[str, int, int], *others: tuple[str, int, int]) -> Values:
    """Return the coupling to one side, collapsed to its middle vertex; 0 if the coupling to that vertex is too weak."""
    side = split(*near).copy()
    for other in others:
        side += split(*other)
    side *= split(*near) > _DIRECT_SHARE * side
    return side


def _felt(split: Split, kind: str) -> Values:
    tie = split(f"tie_{kind}")
    return tie * (tie > _FELT_TIE * (split(f"sum_{kind}") + tie))


def _settle(split: Split, kind: str, held: Values, felt: Values, parts: Mapping[str, Values]) -> None:
    """Set the weights of a kind from its parts.

    ``held`` is the sum of the parts and the off-grid couplings, ``felt`` the ties to fixed heights that count.
    """
    tie, total = split(f"tie_{kind}"), split(f"sum_{kind}")
    off_grid_vertex = held + tie < HELD_SHARE * (total + tie)
    split.keep(f"stray_{kind}")[:] = off_grid_vertex
    scale = np.maximum(held + felt, _TINY)
    np.divide(1, scale, out=scale)
    scale *= ~off_grid_vertex
    split.keep(f"scale_{kind}")[:] = scale
    for place, part in parts.items():
        np.multiply(part, scale, out=split.keep(f"{kind}_{place}"))
    np.multiply(felt, scale, out=split.keep(f"lack_{kind}"))


def _between(split: Split, kind: str, one: Sides, two: Sides) -> None:
    first, second = _side(split, *one[1]), _side(split, *two[1])
    held = first + second + split(f"out_{kind}")
    _settle(split, kind, held, _felt(split, kind), {one[0]: first, two[0]: second})


def _sum(first: Values, *products: tuple[Values, Values]) -> Values:
    out = first.copy()
    for one, two in products:
        add_product(out, one, two)
    return out


def _diagonal(split: Split) -> None:
    """Interpolate from all eight vertices around: the four coarse ones, and the four between them by their weights."""
    north, south = split("s_b"), split("s_d")
    west, east = split("e_u"), split("e_d")
    parts = {
        "nw": _sum(split("se_o"), (north, split("b_w")), (west, split("u_n"))),
        "ne": _sum(split("sw_o", 0, 1), (north, split("b_e")), (east, split("u_n", 0, 1))),
        "sw": _sum(split("sw_d"), (south, split("b_w", 1)), (west, split("u_s"))),
        "se": _sum(split("se_d"), (south, split("b_e", 1)), (east, split("u_s", 0, 1))),
    }
    held, felt = split("out_d").copy(), _felt(split, "d")
    for link, between, down, across in ((north, "b", 0, 0), (south, "b", 1, 0), (west, "u", 0, 0), (east, "u", 0, 1)):
        add_product(held, link, split(f"stray_{between}", down, across))
        add_product(felt, link, split(f"lack_{between}", down, across))
    for part in parts.values():
        held += part
    _settle(split, "d", held, felt, parts)
