"""The input files of `bench.relief`: ``python -m bench.map_files COLSxROWS MOTIF.png THIN.png FULL.png``."""

from __future__ import annotations

import sys

import nmaptool as nm
from bench.maps import Scene, scene
from bench.masks import lines


def main() -> None:
    """Write a map of a motif, one of thin lines and one without background as 16-bit PNG; print their coverage."""
    size, motif, thin, full = sys.argv[1:]
    cols, rows = (int(side) for side in size.split("x"))
    made = scene(rows, cols)
    lined = Scene(made.normals, lines(max(rows, cols))[:rows, :cols] > 0)
    nm.write_normal_map(made.cut_out(), motif)
    nm.write_normal_map(lined.cut_out(), thin)
    nm.write_normal_map(made.all_surface(), full)
    print(f"{made.motif.mean():.3f} {lined.motif.mean():.3f}")


if __name__ == "__main__":
    main()
