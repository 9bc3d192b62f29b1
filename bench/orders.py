"""How maps in every order and sign of the axes are read: ``python -m bench.orders``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import nmaptool as nm
from bench.order_maps import Stored, TrueMap, analytic, baked, storages, textures
from bench.table import table
from nmaptool.maps.order_doubts import order_notes

SAMPLES = Path(__file__).parents[1] / "samples"
RIGHT, SAID, NAMED, DOUBTED, SILENT = "right", "right, said", "wrong, named", "wrong, doubted", "wrong, silent"
OUTCOMES = (RIGHT, SAID, NAMED, DOUBTED, SILENT)
_RIGHT_DEG = 1.0


def outcome(true: TrueMap, stored: Stored) -> str:
    """How a stored map is read: right or wrong, and what is said about it.

    "named" means that a warning, a note or the refusal gives the swizzle that reads it right.
    """
    try:
        read = nm.decode_normal_map(stored.pixels)
    except nm.InputError as error:
        return NAMED if f"'{stored.swizzle}'" in str(error) else DOUBTED
    cosine = np.einsum("ijk,ijk->ij", read.normals, true.normals)[true.motif]
    said = " ".join((*nm.diagnose(read), *read.decoding.warnings, *order_notes(read.decoding)))
    if np.degrees(np.arccos(np.median(cosine).clip(-1, 1))) < _RIGHT_DEG:
        return SAID if said else RIGHT
    if f"'{stored.swizzle}'" in said:
        return NAMED
    return DOUBTED if said else SILENT


def outcomes(true: TrueMap) -> Counter[str]:
    """The number of storages of a map by outcome."""
    return Counter(outcome(true, stored) for stored in storages(true))


def report(maps: Iterable[TrueMap]) -> str:
    """The table of all maps."""
    rows, total = [], Counter[str]()
    for true in maps:
        found = outcomes(true)
        total += found
        rows.append([true.name, *(str(found[one]) for one in OUTCOMES)])
    rows.append(["all", *(str(total[one]) for one in OUTCOMES)])
    return table(["map, 48 storages", *OUTCOMES], rows)


if __name__ == "__main__":
    print(report([*analytic(), *textures(), *baked(SAMPLES)]))
