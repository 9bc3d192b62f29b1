"""Read the fonts and drawings that the design of a plate names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nmaptool.io.fonts import read_font
from nmaptool.io.vector.outline import read_svg_outline
from nmaptool.io.vector.profile import read_svg_profile
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.types.plate import PlateDesign

_FONT_ENDINGS = (".ttf", ".otf", ".ttc", ".otc", ".woff", ".woff2")


def read_design(
    plate: PlateOptions,
    frame: FrameOptions | None = None,
    texts: Sequence[TextOptions] = (),
    machine: MachineOptions | None = None,
    *,
    folder: str | Path = "",
) -> PlateDesign:
    """Read the files of a plate's design: the SVG files of its shape and frame, and its fonts.

    Parameters
    ----------
    plate : PlateOptions
        With a shape.
    frame : FrameOptions, optional
    texts : sequence of TextOptions
    machine : MachineOptions, optional
    folder : str or Path
        Folder that file names are relative to. Default: the current folder.

    Returns
    -------
    PlateDesign

    Raises
    ------
    InputError
        If a file cannot be read, is not what is expected, or a font is not installed.

    Examples
    --------
    >>> plate = nm.PlateOptions(shape="round", hole="3mm@50%,5mm")
    >>> nm.read_design(plate, texts=[nm.TextOptions(text="ANNO 2026", text_path="arc")])
    <PlateDesign round, 1 text>
    """
    frame, machine = frame or FrameOptions(), machine or MachineOptions()
    assert plate.shape is not None or not plate.is_drawn
    outline = read_svg_outline(Path(folder) / plate.shape) if plate.shape is not None and plate.is_drawn else None
    profile = read_svg_profile(Path(folder) / frame.frame_profile) if frame.is_drawn else None
    names = dict.fromkeys(text.font for text in texts)
    fonts = {name: read_font(str(Path(folder) / name) if _is_file(name) else name) for name in names}
    return PlateDesign(plate, frame, tuple(texts), machine, fonts, outline, profile)


def _is_file(font: str) -> bool:
    return Path(font).suffix.lower() in _FONT_ENDINGS
