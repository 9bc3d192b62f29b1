"""The inputs of a relief at another size of pixels."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from nmaptool.composition.transform import transform
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.core.units import Length
from nmaptool.options import ReliefOptions, TransformOptions
from nmaptool.options.plates import MachineOptions
from nmaptool.reliefs.inputs import pitch_of
from nmaptool.reliefs.relief import relief
from nmaptool.types.height import Height
from nmaptool.types.inputs import as_normal_map
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.plain_arrays import as_float32
from nmaptool.types.relief import Relief, ReliefReport

_LARGEST_MEGAPIXELS = 270.0


def resampled(inputs: Mapping[str, Any], cols: int, rows: int, pitch_mm: float) -> dict[str, Any]:
    """Maps and grey pictures at another size.

    Parameters
    ----------
    inputs : mapping
        Arguments of `nmaptool.relief`: NormalMaps, (H, W) arrays, and None.
    cols, rows : int
        The new size.
    pitch_mm : float
        Size of a new pixel.

    Raises
    ------
    LimitError
        If the new size has more than 270 megapixels.
    UsageError
        If the curved background is a height field.
    """
    if cols * rows > _LARGEST_MEGAPIXELS * 1e6:
        raise LimitError(
            f"`pitch='{pitch_mm:.4g}mm'`: would make a picture of {cols} x {rows} px; at most "
            f"{_LARGEST_MEGAPIXELS:g} megapixels are possible, so use a larger pitch"
        )
    return {name: _one(name, value, cols, rows, pitch_mm) for name, value in inputs.items()}


def _one(name: str, value: Any, cols: int, rows: int, pitch_mm: float) -> Any:
    if value is None:
        return None
    if isinstance(value, Height):
        raise UsageError("`surface`: heights of a curved background keep their size; give a normal map, or no `pitch`")
    if name in ("original", "detail", "surface"):
        return _resized_map(as_normal_map(value, f"the {name}"), cols, rows, pitch_mm)
    return _resized_grey(as_float32(value, name), cols, rows)


def _resized_map(normal_map: NormalMap, cols: int, rows: int, pitch_mm: float) -> NormalMap:
    found = transform(normal_map, TransformOptions(resize=f"{cols}x{rows}")).normal_map
    return dataclasses.replace(found, frame=dataclasses.replace(found.frame, pitch_mm=pitch_mm))


def _resized_grey(values: Float32, cols: int, rows: int) -> Float32:
    import cv2

    smaller = cols < values.shape[1]
    method = cv2.INTER_AREA if smaller else cv2.INTER_LINEAR
    found = cv2.resize(values, (cols, rows), interpolation=method)
    # sums of weights may be a rounding more than 1
    return np.asarray(np.clip(found, values.min(), values.max()), np.float32)


def reported(report: ReliefReport, original: NormalMap, options: ReliefOptions) -> ReliefReport:
    """A report with the options as they were given, and where the size was known from."""
    return dataclasses.replace(report, options=options, pitch_from=pitch_of(original, options)[1])


def relief_at_pitch(inputs: Mapping[str, Any], machine: MachineOptions, progress: Progress | None = None) -> Relief:
    """Solve a relief without a plate at the pitch of a machine; errors are those of `inputs_at_pitch` and `relief`."""
    found = relief(**inputs_at_pitch(inputs, machine), progress=progress)
    if machine.pitch is None:
        return found
    original = as_normal_map(inputs["original"], "the original")
    options = inputs.get("options") or ReliefOptions()
    return dataclasses.replace(found, report=reported(found.report, original, options))


def inputs_at_pitch(inputs: Mapping[str, Any], machine: MachineOptions) -> dict[str, Any]:
    """The inputs of a relief at the pitch of a machine, for a relief without a plate.

    Parameters
    ----------
    inputs : mapping
        Arguments of `nmaptool.relief`, with its options.
    machine : MachineOptions
        Without ``pitch``, the inputs stay as they are.

    Returns
    -------
    dict
        Arguments of `nmaptool.relief`.

    Raises
    ------
    LimitError
        If the new size has more than 270 megapixels.
    UsageError
        If the curved background is a height field.

    Examples
    --------
    >>> flat = np.zeros((20, 50, 3))
    >>> flat[..., 2] = 1
    >>> options = nm.ReliefOptions(width=nm.length("10mm"))
    >>> nm.inputs_at_pitch({"original": flat, "options": options}, nm.MachineOptions(pitch="0.1mm"))["original"].frame
    Frame(rows=40, cols=100, pitch_mm=0.1)
    """
    if machine.pitch is None:
        return dict(inputs)
    options = inputs.get("options") or ReliefOptions()
    original = as_normal_map(inputs["original"], "the original")
    pitch_mm, _ = pitch_of(original, options)
    frame = original.frame
    cols, rows = (max(4, round(n * pitch_mm / machine.pitch.to_mm(1.0, 1))) for n in (frame.cols, frame.rows))
    if (cols, rows) == (frame.cols, frame.rows):
        return dict(inputs)
    new_mm = pitch_mm * frame.cols / cols
    maps = {name: value for name, value in inputs.items() if name != "options"}
    width = Length(new_mm * cols, "mm")
    return {**resampled(maps, cols, rows, new_mm), "options": dataclasses.replace(options, width=width)}
