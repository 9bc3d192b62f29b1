"""Solves the document: on a small grid while a control moves, in full when the hand rests."""

from __future__ import annotations

import dataclasses
from typing import Any

import cv2
import numpy as np

from nmaptool.composition.transform import transform
from nmaptool.core.progress import Progress
from nmaptool.io.recipes.scenes import Scene, read_greys, read_scene
from nmaptool.io.recipes.stacks import PictureCache
from nmaptool.options import ReliefOptions, TransformOptions
from nmaptool.options.relief import SMALLEST_BETA
from nmaptool.reliefs.session import ReliefSession
from nmaptool.reliefs.targets import REFERENCE_SIDE_PX
from nmaptool.studio.document import Document
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.relief_parts import ReliefParts

# longer sides of the grids that are solved at once, and while a control moves on a slow machine
PREVIEW_PX = 512
QUICK_PX = 256
# tolerance of their heights
PREVIEW_TOLERANCE, QUICK_TOLERANCE = 2e-5, 2e-4


def has_parts(options: ReliefOptions) -> bool:
    """Whether the page can compute other heights from two parts: not if walls may stand."""
    return options.edge == "blend"


def uses_width(document: Document) -> bool:
    """Whether the parts depend on the width, as with a curved background in mm; otherwise only the page uses it."""
    return document.relief.files.surface is not None or document.options.outline_round is not None


class Engine:
    """The maps of a document, and a session for each grid that was asked for.

    Parameters
    ----------
    document : Document
    cache : PictureCache, optional
        Keeps the maps for the next engine.
    before : Engine, optional
        The engine of the document before; its maps are used if only masks or weights changed.

    Raises
    ------
    InputError, LimitError
        If a file of the document cannot be read.
    """

    def __init__(self, document: Document, cache: PictureCache | None = None, before: Engine | None = None) -> None:
        self.files = _files(document)
        self._maps = _maps(document)
        self.scene: Scene
        self._smaller: dict[int, tuple[NormalMap, NormalMap | None]] = {}
        if before is not None and before._maps == self._maps:  # only masks or weights changed
            files = document.relief.files
            self.scene = dataclasses.replace(before.scene, greys=read_greys(files, document.folder))
            self._smaller = before._smaller
        else:
            # the stage shows the relief without its plate
            self.scene = read_scene(dataclasses.replace(document.recipe, plate=None), cache=cache)
        original = self.scene.composition.normal_map
        self.size = original.frame.cols, original.frame.rows
        self.full = self._session(original, self.scene.detail, self.scene.greys)
        self._sessions: dict[int, ReliefSession] = {}

    def is_whole(self, longest: int | None) -> bool:
        """Whether a grid of this longer side is that of the document."""
        return longest is None or max(self.size) <= longest or self.scene.surface is not None

    def fits(self, document: Document) -> bool:
        """Whether another document needs the same maps."""
        return _files(document) == self.files

    def parts(
        self, options: ReliefOptions, *, longest: int | None = None, progress: Progress | None = None
    ) -> ReliefParts:
        """Solve for the parts of the heights; if they have none, for the heights, as the first part.

        Parameters
        ----------
        options : ReliefOptions
        longest : int, optional
            Longer side of the grid in px; its heights are less exact then. Default: that of the document.
        progress : callable, optional
        """
        if not self.is_whole(longest) and options.per_pixel:
            return self._per_pixel(options, longest, progress)
        session = self.full if longest is None or self.is_whole(longest) else self._reduced(longest)
        tolerance = {None: None, QUICK_PX: QUICK_TOLERANCE}.get(longest, PREVIEW_TOLERANCE)
        if has_parts(options):
            if self.scene.surface is None and options.outline_round is None:
                options = dataclasses.replace(options, width=None)  # the page needs the map's own, if there is none
            return session.parts(options, preview_tolerance=tolerance, progress=progress)
        solved = session.solve(options, preview_tolerance=tolerance, progress=progress)
        height = solved.height
        pitch_mm, per_delta = solved.report.pitch_mm, solved.report.px_per_delta
        z_px = height.z_mm / pitch_mm
        return ReliefParts(z_px, np.zeros_like(z_px), None, height.domain, height.frame, pitch_mm, per_delta)

    def _per_pixel(self, options: ReliefOptions, longest: int | None, progress: Progress | None) -> ReliefParts:
        """Solve on the small grid for beta and delta in pixels of the document, which are smaller than its own."""
        scale = max(self.size) / REFERENCE_SIDE_PX
        beta = max(options.beta * scale**2, SMALLEST_BETA) if options.beta else 0.0
        scaled = dataclasses.replace(options, per_pixel=False, beta=beta, delta=options.delta / scale)
        parts = self.parts(scaled, longest=longest, progress=progress)
        return dataclasses.replace(parts, px_per_delta=parts.px_per_delta / scale)

    def _session(self, original: NormalMap, detail: NormalMap | None, greys: dict[str, Any]) -> ReliefSession:
        return ReliefSession(original, detail, surface=self.scene.surface, **greys)

    def _reduced(self, longest: int) -> ReliefSession:
        """Return the session of a smaller grid."""
        if longest in self._sessions:
            return self._sessions[longest]
        share = longest / max(self.size)
        cols, rows = (max(1, round(side * share)) for side in self.size)
        if longest not in self._smaller:
            # from the next larger grid, which takes less time than from a large map
            larger = min((known for known in self._smaller if known > longest), default=None)
            whole = self.scene.composition.normal_map, self.scene.detail
            original, detail = whole if larger is None else self._smaller[larger]
            small = None if detail is None else _smaller(detail, (cols, rows))
            self._smaller[longest] = _smaller(original, (cols, rows)), small
        greys = {
            role: np.asarray(cv2.resize(grey, (cols, rows), interpolation=cv2.INTER_AREA), np.float32)
            for role, grey in self.scene.greys.items()
        }
        self._sessions[longest] = self._session(*self._smaller[longest], greys)
        return self._sessions[longest]


def _smaller(normal_map: NormalMap, size: tuple[int, int]) -> NormalMap:
    return transform(normal_map, TransformOptions(resize=f"{size[0]}x{size[1]}")).normal_map


def _maps(document: Document) -> tuple[object, ...]:
    """Return what the composed map, the detail map and the surface depend on."""
    files = document.relief.files
    # a surface in mm depends on the size of a pixel
    width = document.relief.options.get("width") if files.surface is not None else None
    return document.layers, document.canvas, document.folder, files.detail, files.surface, width


def _files(document: Document) -> tuple[object, ...]:
    """Return what the sessions depend on."""
    return *_maps(document), document.relief.files
