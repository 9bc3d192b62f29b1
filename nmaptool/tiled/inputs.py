"""The inputs of a relief by tiles: opened once to settle how they are read, and watched for changes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.stores.grey import GreyStore, open_grey
from nmaptool.io.stores.heights import open_heights
from nmaptool.io.stores.normal_maps import open_normal_map
from nmaptool.io.stores.opening import open_picture
from nmaptool.options import ReadOptions, ReliefFiles
from nmaptool.reliefs.inputs import SAME_PITCH
from nmaptool.types.plain_arrays import check_sizes

# inputs that hold one value for each pixel
GREYS = ("mask", "wall_mask", "mu_map", "beta_map", "delta_map")


@dataclass(frozen=True)
class Sources:
    """The inputs of a relief.

    Attributes
    ----------
    original : str
    rows, cols : int
    pitch_mm : float or None
    background : str
        Kind of the original's background.
    reading, detail_reading : ReadOptions
        How the maps are read, with nothing left to detect.
    greys : dict of str to GreyStore
        The mask and the maps of weights, by the names of their fields.
    stamps : dict of str to str
        For each input, a text that changes when it does.
    warnings : tuple of str
    """

    original: str
    rows: int
    cols: int
    pitch_mm: float | None
    background: str
    reading: ReadOptions
    detail_reading: ReadOptions | None
    greys: dict[str, GreyStore]
    stamps: dict[str, str]
    warnings: tuple[str, ...] = ()

    def check_unchanged(self) -> None:
        """Check that the inputs are as they were.

        Raises
        ------
        InputError
            If one has changed.
        """
        for name, stamp in self.stamps.items():
            if open_picture(name).stamp() != stamp:
                raise InputError(f"{name}: changed while it was read; wait until it is complete, and run again")


def check_background(name: str, pitch_mm: float) -> None:
    """Check that a curved background can be read by windows.

    Raises
    ------
    InputError
        If its heights are not at corners, or have another pitch.
    """
    source = open_heights(name)
    if source.at != "corners":
        raise InputError(
            f"the curved background {name} has heights at pixel centres; a large map needs them at corners: write them "
            "with `at='corners'`"
        )
    if abs(source.pitch_mm - pitch_mm) > SAME_PITCH * pitch_mm:
        raise InputError(
            f"the curved background {name} has {source.pitch_mm:.4g} mm per pixel but the relief {pitch_mm:.4g}; give "
            "both the same `width`"
        )


def open_sources(original: str, files: ReliefFiles, reading: ReadOptions) -> Sources:
    """Open all inputs, check their sizes, and settle how the maps are read.

    Raises
    ------
    InputError
        If one cannot be read, or sizes differ.
    """
    first = open_normal_map(original, reading)
    detail = None
    if files.detail is not None:
        detail = open_normal_map(files.detail, dataclasses.replace(reading, layer=None), like=first)
    given = {name: file for name, file in dataclasses.asdict(files).items() if file is not None}
    sizes: dict[str, tuple[int, ...]] = {}
    stamps = {original: open_picture(original).stamp()}
    for role, file in given.items():
        picture = open_picture(file)
        extra = 1 if role == "surface" else 0
        sizes[f"the {role.replace('_', ' ')} {file}"] = (picture.rows - extra, picture.cols - extra)
        stamps[file] = picture.stamp()
    check_sizes(original, (first.rows, first.cols), sizes)
    if files.mu_map is not None and files.detail is None:
        raise UsageError("`mu_map`: has no effect without a detail map; give one with `detail`")
    return Sources(
        original,
        first.rows,
        first.cols,
        first.pitch_mm,
        first.decoding.background,
        first.settled,
        None if detail is None else detail.settled,
        {role: open_grey(file) for role, file in given.items() if role in GREYS},
        stamps,
        tuple(first.decoding.warnings),
    )
