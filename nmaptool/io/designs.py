"""Read the fonts and drawings that the design of a plate names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nmaptool.core.errors import InputError
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.options.plates.text import is_font_file
from nmaptool.types.plate import PlateDesign
from nmaptool.types.recipe_plate import RecipePlate


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
    # take long to load
    from nmaptool.io.fonts import read_font
    from nmaptool.io.vector.outline import read_svg_outline
    from nmaptool.io.vector.profile import read_svg_profile

    frame, machine = frame or FrameOptions(), machine or MachineOptions()
    outline = read_svg_outline(Path(folder) / plate.shape) if plate.shape is not None and plate.is_drawn else None
    profile = read_svg_profile(Path(folder) / frame.frame_profile) if frame.is_drawn else None
    names = dict.fromkeys(text.font for text in texts)
    fonts = {name: read_font(str(Path(folder) / name) if is_font_file(name) else name) for name in names}
    return PlateDesign(plate, frame, tuple(texts), machine, fonts, outline, profile)


def design_of(plate: RecipePlate | None, folder: str | Path = "") -> PlateDesign | None:
    """The design of a recipe's plate; None without a shape.

    Raises
    ------
    InputError
        If a frame or text has no plate, and as for `read_design`.
    """
    if plate is None:
        return None
    if plate.plate.get("shape") is None:
        given = "[frame]" if plate.frame else "[[text]]" if plate.texts else None
        if given is not None:
            raise InputError(f'{given}: needs a plate; add [plate] with a shape, such as shape = "round"')
        return None
    texts = [TextOptions(**text) for text in plate.texts]
    options = PlateOptions(**plate.plate), FrameOptions(**plate.frame), texts, plate.machine_options
    return read_design(*options, folder=folder)
