"""Time and size of every compression that a format offers without loss: ``python -m bench.compression [--side 2048]``.

`nmaptool.io.compression` has what was chosen; docs/decisions/0034-compression.md says why.
"""

from __future__ import annotations

import importlib
import tempfile
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - the name in its documentation
from numpy.typing import NDArray

import nmaptool as nm
from bench.maps import scene
from bench.report import Report
from bench.surfaces import bumps
from bench.table import table
from nmaptool.io import compression
from nmaptool.io.solids.threemf import MODEL_PATH
from nmaptool.io.solids.writer import write_solid

_PIECE_BYTES = 1 << 20
# modules with the interface of zlib, which are not needed by nmaptool and measured if they are installed
_RIVALS = (("isal", "isal.isal_zlib", (0, 1, 2, 3)), ("zlib-ng", "zlib_ng.zlib_ng", (1, 2, 3, 6)))
_FILTERS = {0: "chosen for each row", 16: "left", 32: "up", 64: "average", 128: "Paeth"}


@dataclass(frozen=True)
class Found:
    """CPU seconds of packing and unpacking, and bytes before and after."""

    packing: float
    unpacking: float
    before: int
    after: int

    def cells(self) -> list[str]:
        """The cells of the table that follow the names."""
        share = f"{self.after / self.before:.0%}"
        return [f"{self.packing:.2f}", f"{self.unpacking:.2f}", f"{self.after / 1e6:.1f}", share]


def timed(work: Callable[[], Any], repeats: int) -> float:
    """Least CPU time of some runs in seconds."""
    least = float("inf")
    for _ in range(repeats):
        started = time.process_time()
        work()
        least = min(least, time.process_time() - started)
    return least


def deflated(module: Any, level: int, text: bytes, repeats: int) -> Found:
    """A text packed and unpacked piece by piece, as in a 3MF file."""
    packed: list[bytes] = []

    def pack() -> None:
        stream = module.compressobj(level, 8, -15)
        packed[:] = [stream.compress(text[at : at + _PIECE_BYTES]) for at in range(0, len(text), _PIECE_BYTES)]
        packed.append(stream.flush())

    def unpack() -> None:
        stream = module.decompressobj(-15)
        for piece in packed:
            stream.decompress(piece)

    packing = timed(pack, repeats)
    return Found(packing, timed(unpack, repeats), len(text), sum(map(len, packed)))


def model_text(side: int) -> bytes:
    """The text in the 3MF file of a solid."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "solid.3mf"
        options = nm.SolidOptions(base=nm.length("3mm"))
        write_solid(nm.solid(bumps(side, side), options), path, is_checked=False)
        with zipfile.ZipFile(path) as archive:
            return archive.read(MODEL_PATH)


def text_rows(side: int, repeats: int) -> Iterator[list[str]]:
    """The rows of 3MF."""
    text = model_text(side)
    modules: list[tuple[str, Any, tuple[int, ...]]] = [("zlib", zlib, (0, 1, 2, 3, 6))]
    for name, module, levels in _RIVALS:
        try:
            modules.append((name, importlib.import_module(module), levels))
        except ImportError:
            continue
    for name, module, levels in modules:
        for level in levels:
            chosen = module is zlib and level == compression.LEVEL_OF_3MF
            found = deflated(module, level, text, repeats)
            yield ["3MF", "solid", f"{name} {level}", *found.cells(), "chosen" if chosen else ""]


def picture(pixels: NDArray[Any], path: Path, attributes: Mapping[str, str | int], repeats: int) -> Found:
    """A picture written and read by OpenImageIO.

    Raises
    ------
    RuntimeError
        If it cannot be written.
    """
    rows, cols, count = pixels.shape
    spec = oiio.ImageSpec(cols, rows, count, {"u1": "uint8", "u2": "uint16", "f4": "float"}[pixels.dtype.str[1:]])
    spec.attribute("oiio:ColorSpace", "data")
    for key, value in attributes.items():
        spec.attribute(key, value)

    def write() -> None:
        sink: Any = oiio.ImageOutput.create(str(path))
        if not (sink.open(str(path), spec) and sink.write_image(pixels) and sink.close()):
            raise RuntimeError(f"{path}: {sink.geterror()}")

    def read() -> None:
        source: Any = oiio.ImageInput.open(str(path))
        source.read_image(format=source.spec().format)
        source.close()

    packing = timed(write, repeats)
    return Found(packing, timed(read, repeats), pixels.nbytes, path.stat().st_size)


def _choices() -> Iterator[tuple[str, str, dict[str, str | int]]]:
    """Endings, names and attributes of the compressions of pictures."""
    for level, row_filter in ((0, 0), (5, 0), (1, 0), (1, 16), (1, 32), (1, 64), (1, 128), (3, 32), (5, 32)):
        attributes = {"png:compressionLevel": level} | ({"png:filter": row_filter} if row_filter else {})
        yield ".png", f"level {level}, filter {_FILTERS[row_filter]}", dict(attributes)
    for name in ("none", "rle", "zips", "zip:1", "zip", "piz"):
        yield ".exr", name, {"compression": name}
    for name in ("none", "lzw", "zip"):
        yield ".tif", name, {"compression": name}


def picture_rows(side: int, repeats: int) -> Iterator[list[str]]:
    """The rows of pictures: maps of a motif on plain ground and of a full frame, and heights of a full frame."""
    made, heights = scene(side, side), bumps(side, side).at_pixels()
    share = (heights - heights.min()) / np.ptp(heights)
    full = made.normals
    motif = np.where(made.motif[..., None], full, np.float32([0, 0, 1]))
    floats = {"normals": full, "normals of a motif": motif, "heights": heights.astype(np.float32)[..., None]}
    codes = {
        "16-bit normals": _codes(full, 16),
        "16-bit normals of a motif": _codes(motif, 16),
        "8-bit normals": _codes(full, 8),
        "16-bit heights": (share * 65535 + 0.5).astype(np.uint16)[..., None],
    }
    with tempfile.TemporaryDirectory() as folder:
        for ending, name, attributes in _choices():
            for what, pixels in (codes if ending == ".png" else floats).items():
                found = picture(np.ascontiguousarray(pixels), Path(folder) / f"a{ending}", attributes, repeats)
                chosen = attributes == compression.PICTURES[ending]
                yield [ending[1:].upper(), what, name, *found.cells(), "chosen" if chosen else ""]


def _codes(normals: NDArray[Any], bits: int) -> NDArray[Any]:
    return ((normals + 1) / 2 * (2**bits - 1) + 0.5).astype(np.uint16 if bits == 16 else np.uint8)


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("compression", __doc__)
    report.argument("--side", type=int, default=2048, help="side of the pictures in pixels (default 2048)")
    report.argument("--repeat", type=int, default=2, help="number of runs; the shortest time counts (default 2)")
    options = report.begin()
    rows = [*text_rows(options.side, options.repeat), *picture_rows(options.side, options.repeat)]
    rows.sort(key=lambda row: row[:2])
    head = ("format", "content", "compression", "write CPU s", "read CPU s", "MB", "of plain", "")
    report.end(f"Contents of {options.side} x {options.side} px.", table(head, rows))


if __name__ == "__main__":
    main()
