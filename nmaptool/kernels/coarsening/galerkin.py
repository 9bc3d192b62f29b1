"""Couplings of the coarser grid: P^T A P, for the interpolation P and the couplings of a band.

A is stored as its couplings and its ties to fixed heights, all non-negative; the diagonal, which is their sum, is not
stored. A surface without ties thus keeps its free constant exactly on every level, whatever the rounding. Ties are
lumped.
"""

from __future__ import annotations

import numpy as np

from nmaptool.kernels.coarsening.split import LINKS, Split
from nmaptool.kernels.grid_twins import Values, add_product

_Term = tuple[str, int, int]
# the vertices that interpolate from the coarse vertex at (0, 0): kind, down, across, and the weight's name
TAKES: tuple[tuple[str, int, int, str], ...] = (
    ("b", 0, 0, "b_w"),
    ("b", 0, -1, "b_e"),
    ("u", 0, 0, "u_n"),
    ("u", -1, 0, "u_s"),
    ("d", 0, 0, "d_nw"),
    ("d", 0, -1, "d_ne"),
    ("d", -1, 0, "d_sw"),
    ("d", -1, -1, "d_se"),
)


def _sum(split: Split, *terms: tuple[_Term, ...]) -> Values:
    """Return the first term plus the products of the others."""
    (start,), *products = terms
    out = split(*start).copy()
    for one, two in products:
        add_product(out, split(*one), split(*two))
    return out


def coarse_couplings(split: Split) -> dict[str, Values]:
    """Return the couplings "e", "s", "se", "sw" of the coarse vertices of the band, none negative."""
    split.reach(0)
    out = {"e": _east(split), "s": _south(split), "se": _south_east(split), "sw": _south_west(split)}
    for values in out.values():
        np.maximum(values, 0, out=values)
    return out


def _east(split: Split) -> Values:
    """Return the couplings to (0, 1): via the vertex beside it, and the diagonal ones south and north of that."""
    b_w, b_e = split("b_w"), split("b_e")
    to_south, from_south = split("d_nw"), split("d_ne")
    to_north, from_north = split("d_sw", -1), split("d_se", -1)
    # from the column of (0, 0) to the column between, and from there to the column of (0, 1)
    out = b_e * _sum(split, (("e_o", 0, 0),), (("sw_b", 0, 0), ("u_n", 0, 0)), (("se_u", -1, 0), ("u_s", -1, 0)))
    add_product(out, from_south, _sum(split, (("se_o", 0, 0),), (("e_u", 0, 0), ("u_n", 0, 0))))
    add_product(out, from_north, _sum(split, (("sw_d", -1, 0),), (("e_u", -1, 0), ("u_s", -1, 0))))
    add_product(
        out, b_w, _sum(split, (("e_b", 0, 0),), (("se_b", 0, 0), ("u_n", 0, 1)), (("sw_u", -1, 1), ("u_s", -1, 1)))
    )
    add_product(out, to_south, _sum(split, (("sw_o", 0, 1),), (("e_d", 0, 0), ("u_n", 0, 1))))
    add_product(out, to_north, _sum(split, (("se_d", -1, 0),), (("e_d", -1, 0), ("u_s", -1, 1))))
    # within the column between
    add_product(out, split("s_b"), b_w * from_south + to_south * b_e)
    add_product(out, split("s_d", -1), b_w * from_north + to_north * b_e)
    out -= split("sum_b") * b_w * b_e
    out -= split("sum_d") * to_south * from_south
    out -= split("sum_d", -1) * to_north * from_north
    return out


def _south(split: Split) -> Values:
    """Return the couplings to (1, 0): via the vertex below it, and the diagonal ones east and west of that."""
    u_n, u_s = split("u_n"), split("u_s")
    to_east, from_east = split("d_nw"), split("d_sw")
    to_west, from_west = split("d_ne", 0, -1), split("d_se", 0, -1)
    out = u_s * _sum(split, (("s_o", 0, 0),), (("sw_b", 0, 0), ("b_w", 0, 0)), (("se_b", 0, -1), ("b_e", 0, -1)))
    add_product(out, from_east, _sum(split, (("se_o", 0, 0),), (("s_b", 0, 0), ("b_w", 0, 0))))
    add_product(out, from_west, _sum(split, (("sw_o", 0, 0),), (("s_b", 0, -1), ("b_e", 0, -1))))
    add_product(
        out, u_n, _sum(split, (("s_u", 0, 0),), (("se_u", 0, 0), ("b_w", 1, 0)), (("sw_u", 0, 0), ("b_e", 1, -1)))
    )
    add_product(out, to_east, _sum(split, (("sw_d", 0, 0),), (("s_d", 0, 0), ("b_w", 1, 0))))
    add_product(out, to_west, _sum(split, (("se_d", 0, -1),), (("s_d", 0, -1), ("b_e", 1, -1))))
    add_product(out, split("e_u"), u_n * from_east + to_east * u_s)
    add_product(out, split("e_d", 0, -1), u_n * from_west + to_west * u_s)
    out -= split("sum_u") * u_n * u_s
    out -= split("sum_d") * to_east * from_east
    out -= split("sum_d", 0, -1) * to_west * from_west
    return out


def _south_east(split: Split) -> Values:
    """Return the couplings to (1, 1): via the diagonal vertex between."""
    into, out_of = split("d_nw"), split("d_se")
    out = out_of * _sum(split, (("se_o", 0, 0),), (("s_b", 0, 0), ("b_w", 0, 0)), (("e_u", 0, 0), ("u_n", 0, 0)))
    add_product(
        out, into, _sum(split, (("se_d", 0, 0),), (("s_d", 0, 0), ("b_e", 1, 0)), (("e_d", 0, 0), ("u_s", 0, 1)))
    )
    out -= split("sum_d") * into * out_of
    add_product(out, split("se_b"), split("b_w"), split("u_s", 0, 1))
    add_product(out, split("se_u"), split("u_n"), split("b_e", 1))
    return out


def _south_west(split: Split) -> Values:
    """Return the couplings to (1, -1): via the diagonal vertex between, which belongs to (0, -1)."""
    into, out_of = split("d_ne", 0, -1), split("d_sw", 0, -1)
    out = out_of * _sum(split, (("sw_o", 0, 0),), (("s_b", 0, -1), ("b_e", 0, -1)), (("e_d", 0, -1), ("u_n", 0, 0)))
    add_product(
        out, into, _sum(split, (("sw_d", 0, -1),), (("s_d", 0, -1), ("b_w", 1, -1)), (("e_u", 0, -1), ("u_s", 0, -1)))
    )
    out -= split("sum_d", 0, -1) * into * out_of
    add_product(out, split("sw_b", 0, -1), split("b_e", 0, -1), split("u_s", 0, -1))
    add_product(out, split("sw_u"), split("u_n"), split("b_w", 1, -1))
    return out


def coarse_ties(split: Split) -> Values:
    """Return the ties of the coarse vertices of the band to fixed heights: P^T A (P 1), none negative."""
    split.reach(1)
    uneven = any(split(f"lack_{kind}").any() for kind in "bud")
    for kind in "obud":
        rest = split(f"tie_{kind}").copy()
        if uneven:
            if kind != "o":
                rest -= (split(f"tie_{kind}") + split(f"sum_{kind}")) * split(f"lack_{kind}")
            for other, down, across, name, link_down, link_across in LINKS[kind]:
                if other != "o":
                    add_product(rest, split(name, link_down, link_across), split(f"lack_{other}", down, across))
        split.keep(f"rest_{kind}")[:] = rest
    split.reach(0)
    out = split("rest_o").copy()
    for kind, down, across, weight in TAKES:
        add_product(out, split(weight, down, across), split(f"rest_{kind}", down, across))
    np.maximum(out, 0, out=out)
    return out
