"""Layers on a large canvas: those whose pixels become pixels are read by windows, others are placed once and stored."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.compose import layer_warnings
from nmaptool.composition.placement import Piece
from nmaptool.composition.placing import Placing, part_for, place, place_part, placing_of
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.normal_maps import read_normal_map
from nmaptool.io.stores.grey import open_grey
from nmaptool.io.stores.normal_maps import open_normal_map
from nmaptool.io.stores.opening import is_store
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import LayerOptions, ReadOptions
from nmaptool.solver.tiling.grid import Box
from nmaptool.tiled.edits import grey_of, map_of
from nmaptool.types.layer_files import LayerFile
from nmaptool.types.layers import Layer, check_mask_size, check_mask_values
from nmaptool.types.picture import Frame
from nmaptool.types.tiled_edit import TiledInput

_PIECES = ("normals", "coverage", "own", "foreground")


@dataclass(frozen=True)
class PlacedLayer:
    """A layer for the tasks.

    Attributes
    ----------
    file : LayerFile
    placing : Placing
    reading : ReadOptions or None
        How its windows are read; None if the placed layer is stored in the work folder.
    number : int
    """

    file: LayerFile
    placing: Placing
    reading: ReadOptions | None
    number: int

    @property
    def options(self) -> LayerOptions:
        """How it is blended."""
        return self.file.options

    @property
    def box(self) -> Box:
        """The rows and columns of the canvas that it may cover."""
        return self.placing.box

    def piece(self, folder: WorkFolder, window: Box) -> tuple[Piece, Float32] | None:
        """The part of the layer in a window of the canvas, as `nmaptool.composition.placing.place` gives it.

        Returns
        -------
        piece, own : Piece, (h, w) float32
            None if it does not reach the window.
        """
        return self._stored(folder, window) if self.reading is None else self._read(window)

    def _read(self, window: Box) -> tuple[Piece, Float32] | None:
        assert self.reading is not None
        needed = part_for(self.placing, window)
        if needed is None:
            return None
        box, part = needed
        mask = None
        if self.file.mask is not None:
            mask = grey_of(self.file.mask).window(*part)
            check_mask_values(mask, self.file.name, self.file.mask)
        source = map_of(self.file.map, self.reading).window(*part)
        return place_part(self.placing, source, mask, box, (part[0].start, part[1].start), window)

    def _stored(self, folder: WorkFolder, window: Box) -> tuple[Piece, Float32] | None:
        known = folder.get(f"placed/{self.number}")
        if known is None:
            raise InputError(f"{folder.url}: the placed layer {self.file.name} is missing; remove the folder")
        top, left, rows, cols = (int(value) for value in known["box"])
        part = (
            slice(max(window[0].start, top), min(window[0].stop, top + rows)),
            slice(max(window[1].start, left), min(window[1].stop, left + cols)),
        )
        if part[0].start >= part[0].stop or part[1].start >= part[1].stop:
            return None
        inner = (
            slice(part[0].start - top, part[0].stop - top),
            slice(part[1].start - left, part[1].stop - left),
        )
        normals, coverage, own, foreground = (folder.read(f"layer{self.number}_{one}", inner) for one in _PIECES)
        at = part[1].start - window[1].start, part[0].start - window[0].start
        return Piece(normals, coverage, foreground.astype(bool), *at), own

    def store(self, folder: WorkFolder, frame: Frame, reading: ReadOptions, chunk: int) -> None:
        """Place the layer and store it in the work folder, unless its windows are read or it is there."""
        if self.reading is not None or folder.get(f"placed/{self.number}") is not None:
            return
        piece, own = place(_in_memory(self.file, reading), frame)
        values: tuple[NDArray[Any], ...] = (piece.normals, piece.coverage, own, piece.foreground.view(np.uint8))
        for name, array in zip(_PIECES, values, strict=True):
            folder.make_array(f"layer{self.number}_{name}", array.shape, array.dtype.str[1:], chunk, packed=True)
            folder.write(f"layer{self.number}_{name}", (slice(0, array.shape[0]), slice(0, array.shape[1])), array)
        folder.put(f"placed/{self.number}", {"box": np.array([piece.top, piece.left, *piece.coverage.shape])})


def _in_memory(file: LayerFile, reading: ReadOptions) -> Layer:
    """The layer as a whole."""
    mask = None
    if file.mask is not None:
        opened_mask = open_grey(file.mask)
        mask = opened_mask.window(slice(0, opened_mask.rows), slice(0, opened_mask.cols))
    if not is_store(file.map, reading.max_megapixels):
        return Layer(read_normal_map(file.map, reading), file.options, mask, file.mask or "")
    opened = open_normal_map(file.map, reading)
    normal_map = opened.window(slice(0, opened.rows), slice(0, opened.cols))
    return Layer(dataclasses.replace(normal_map, name=file.map), file.options, mask, file.mask or "")


def place_files(
    files: tuple[LayerFile, ...], frame: Frame, reading: ReadOptions
) -> tuple[tuple[PlacedLayer, ...], tuple[TiledInput, ...], tuple[str, ...]]:
    """Open layers and find where they lie on a canvas.

    Returns
    -------
    layers : tuple of PlacedLayer
    inputs : tuple of TiledInput
    warnings : tuple of str

    Raises
    ------
    InputError
        If one cannot be read or is outside the canvas, or its mask has another size.
    LimitError
        If a layer that is too large for memory must be resampled.
    """
    layers: list[PlacedLayer] = []
    inputs: list[TiledInput] = []
    warnings: list[str] = []
    for number, file in enumerate(files):
        large = is_store(file.map, reading.max_megapixels)
        if large:
            opened = open_normal_map(file.map, reading)
            own, decoding = Frame(opened.rows, opened.cols, opened.pitch_mm), opened.decoding
        else:
            read = read_normal_map(file.map, reading)
            own, decoding = read.frame, read.decoding
        placing = placing_of(own.shape, file.options, frame, file.name)
        by_windows = large and placing.is_exact
        if large and not by_windows:
            _check_fits(file, own, placing, reading.max_megapixels)
        if file.mask is not None:
            mask = open_grey(file.mask)
            check_mask_size(file.name, (mask.rows, mask.cols), own.shape, file.mask)
        layers.append(PlacedLayer(file, placing, opened.settled if by_windows else None, number))
        inputs.append(TiledInput(file.map, own.rows, own.cols, decoding))
        warnings += layer_warnings(file.name, own.pitch_mm, file.options, frame)
    return tuple(layers), tuple(inputs), tuple(warnings)


def _check_fits(file: LayerFile, own: Frame, placing: Placing, max_megapixels: float) -> None:
    rows, cols = (side.stop - side.start for side in placing.box)
    megapixels = max(own.rows * own.cols, rows * cols) / 1e6
    if megapixels > max_megapixels:
        raise LimitError(
            f"{file.name}: has {megapixels:.3g} megapixels and must be resampled, which is done in memory, up to "
            f"{max_megapixels:g}; use quarter turns and `scale='1'`, or raise `max_megapixels`"
        )
