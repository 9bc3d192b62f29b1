"""The folder of a batch in a test, and its JSON lines."""

import json
from pathlib import Path

import numpy as np


def fill_with_maps(folder, dome, codes, png):
    """Write three good maps, a text file, a grey picture and an empty file into ``folder/maps``; return the folder."""
    (folder / "maps").mkdir()
    for number, rise in enumerate((0.4, 0.6, 0.8)):
        d = dome(rise=rise)
        png(folder / f"maps/good{number}.png", np.dstack([codes(d.normals, 16), d.inside.astype(np.uint16) * 65535]))
    (folder / "maps/bad.png").write_text("hello\n", encoding="utf-8")
    png(folder / "maps/grey.png", np.full((96, 96), 200, np.uint8))
    (folder / "maps/empty.png").touch()
    return folder


def lines_of(done):
    """The JSON lines of a batch, by the name of the input."""
    found = [json.loads(line) for line in done.out.splitlines()]
    return {Path(line["inputs"][0]).name: line for line in found}
