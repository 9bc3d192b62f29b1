"""Make the sample meshes, in mm, y up, front towards +z: ``python samples/make_meshes.py FOLDER``.

A turned vase with chased ornament, the head of a young woman with dressed hair, three linked rings, and a town gate.
"""

from __future__ import annotations

import sys
from pathlib import Path

from mesh_gate import gate
from mesh_parts import write_ply
from mesh_portrait import portrait
from mesh_rings import rings
from mesh_vase import vase


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "samples")
    folder.mkdir(parents=True, exist_ok=True)
    for make in (vase, portrait, rings, gate):
        write_ply(folder / f"{make.__name__}.ply", *make())
    total = sum(path.stat().st_size for path in folder.glob("*.ply"))
    print(f"sample meshes in {folder}: {total / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
