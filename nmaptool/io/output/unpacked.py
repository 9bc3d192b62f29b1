"""Unpacked layers to a folder: a map each, their masks, and the recipe that composes them again."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.composition.recipe_toml import to_toml
from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.core.units import Length
from nmaptool.io.pictures.normal_maps import normal_picture
from nmaptool.io.pictures.writer import write_image, write_pictures
from nmaptool.io.replace import check_target, named, written_beside
from nmaptool.io.unfinished import unfinished
from nmaptool.maps.codec import grey_codes
from nmaptool.options import CanvasOptions, GroupOptions, LayerMode, LayerOptions
from nmaptool.types.recipe import Recipe, RecipeGroup, RecipeLayer
from nmaptool.types.unpacked import UnpackedLayer, UnpackResult
from nmaptool.types.workspace import NORMAL_BLEND, PASS_THROUGH, WorkspaceGroup

FORMATS = ("exr", "png")
RECIPE = "recipe.toml"
_LONGEST_NAME_BYTES = 100
# names that Windows keeps for devices
_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}


def safe_names(names: Sequence[str]) -> list[str]:
    """File names without ending for layers of any name: plain, short, different from each other on every system.

    >>> safe_names(["../x", "a/b", "con", "", "A/B"])
    ['x', 'a_b', '_con', 'layer', 'A_B 2']
    """
    out: list[str] = []
    seen: set[str] = set()
    for name in names:
        whole = unicodedata.normalize("NFC", name.encode("utf-8", "ignore").decode("utf-8"))
        plain = "".join(c if c.isalnum() or c in "-_+ .()" else "_" for c in whole)
        plain = plain.strip(" ._").encode("utf-8")[:_LONGEST_NAME_BYTES].decode("utf-8", "ignore").rstrip(" .")
        plain = plain or "layer"
        if plain.partition(".")[0].strip().casefold() in _DEVICES:
            plain = f"_{plain}"
        found, number = plain, 2
        while unicodedata.normalize("NFKC", found).casefold() in seen:
            found, number = f"{plain} {number}", number + 1
        seen.add(unicodedata.normalize("NFKC", found).casefold())
        out.append(found)
    return out


@dataclass(frozen=True)
class UnpackedFiles:
    """Where unpacked layers go.

    Parameters
    ----------
    folder : Path
        Made if missing.
    format : str
        ``exr`` (floats) or ``png`` (16 bits).
    report : Path or None
        .json.
    overwrite : bool
        Replace files that exist.
    """

    folder: Path
    format: str = "exr"
    report: Path | None = None
    overwrite: bool = False

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If a format or ending is not offered.
        OutputError
            If a target cannot be written or exists.
        """
        if self.format not in FORMATS:
            raise UsageError(f"--format {self.format!r}: use one of {', '.join(FORMATS)}")
        if self.report is not None and self.report.suffix.lower() != ".json":
            raise UsageError(f"{self.report}: a report is written as .json")
        folder, above = self.folder, self.folder.parent
        try:
            if folder.exists() and not folder.is_dir():
                raise OutputError(f"{folder}: is a file; layers are unpacked into a folder; give another name")
            if not above.is_dir():
                raise OutputError(f"{folder}: the folder {above} does not exist; make it first")
            if self.report is not None and (self.report.parent != folder or folder.exists()):
                check_target(self.report, self.overwrite)
            if folder.is_dir():
                check_target(folder / RECIPE, self.overwrite)
        except OutputError:
            raise
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written ({reason_of(error)})") from None

    @contextlib.contextmanager
    def made(self) -> Iterator[None]:
        """The folder, removed again where the block fails and it was not there before."""
        new = not self.folder.is_dir()
        if new:
            try:
                self.folder.mkdir()
            except OSError as error:
                raise OutputError(f"{self.folder}: cannot be made ({reason_of(error)})") from None
        try:
            with unfinished(folders=[self.folder] if new else []):
                yield
        except BaseException:
            if new:
                with contextlib.suppress(OSError):
                    self.folder.rmdir()
            raise


def write_unpacked(
    unpacked: UnpackResult,
    folder: str | Path,
    *,
    format: str = "exr",
    report: str | Path | None = None,
    overwrite: bool = False,
    metadata: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Write a map per layer, masks, and ``recipe.toml``: all files appear, or none.

    Parameters
    ----------
    unpacked : Unpacked
    folder : str or Path
        Made if missing.
    format : str
        ``exr`` (floats) or ``png`` (16 bits).
    report : str or Path, optional
        JSON account.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``unpacked.to_dict()``.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    UsageError
        If a format or ending is not offered.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> written = nm.write_unpacked(nm.unpack(nm.pack([flat])), "unpacked", format="png")
    >>> sorted(path.suffix for path in written)
    ['.png', '.toml']
    """
    files = UnpackedFiles(Path(folder), format, Path(report) if report is not None else None, overwrite)
    files.check()
    jobs: list[tuple[Path, Callable[[Path], object]]] = []
    entries: list[dict[str, Any]] = []
    for layer, name in zip(unpacked.layers, safe_names([one.name for one in unpacked.layers]), strict=True):
        picture = files.folder / f"{name}.{format}"
        jobs.append((picture, partial(_write_map, layer=layer, floating=format == "exr")))
        entries.append({"name": layer.name, "file": picture.name})
        if layer.mask is not None:
            jobs.append((files.folder / f"{name}.mask.png", partial(_write_mask, layer=layer)))
            entries[-1]["mask"] = jobs[-1][0].name
    text = recipe_text(unpacked, entries)
    jobs.append((files.folder / RECIPE, lambda path: path.write_text(text, encoding="utf-8")))
    if files.report is not None:
        values = json.dumps(metadata if metadata is not None else unpacked.to_dict(), indent=2) + "\n"
        jobs.append((files.report, lambda path: path.write_text(values)))
    targets = [target for target, _ in jobs]
    source = Path(unpacked.name)
    if any(target.exists() and source.exists() and target.samefile(source) for target in targets):
        raise OutputError(f"{source}: is what is unpacked; unpack it into another folder")
    with files.made(), written_beside(targets, overwrite) as beside:
        for (target, job), temporary in zip(jobs, beside, strict=True):
            with named(target, temporary):
                job(temporary)
    return targets


def _write_map(path: Path, layer: UnpackedLayer, floating: bool) -> None:
    write_pictures(path, [normal_picture(layer.normal_map, 32 if floating else 16)])


def _write_mask(path: Path, layer: UnpackedLayer) -> None:
    assert layer.mask is not None
    write_image(path, grey_codes(layer.mask, 16)[..., None], ("Y",), {"kind": "mask", "version": __version__})


def recipe_text(unpacked: UnpackResult, entries: Sequence[Mapping[str, str]]) -> str:
    """The recipe that ``nmap compose stack`` composes the layers by again, bottom to top.

    Parameters
    ----------
    unpacked : Unpacked
    entries : sequence of mapping
        ``file`` and, where there is one, ``mask`` of each layer.
    """
    frame = unpacked.frame
    width = None if frame.pitch_mm is None else Length(frame.cols * frame.pitch_mm, "mm")
    canvas = CanvasOptions(f"{frame.cols}x{frame.rows}", width, "flat" if unpacked.ground == "flat" else "clear")
    pairs = list(zip(unpacked.layers, entries, strict=True))
    recipe = Recipe(tuple(_entries(pairs, 0)), canvas, name=unpacked.name)
    stated = f"# {_plain(Path(unpacked.name).name)}, unpacked by nmaptool {__version__}; bottom to top\n\n"
    return stated + to_toml(recipe)


def _mixed_first(layer: UnpackedLayer) -> tuple[WorkspaceGroup, ...]:
    """The recipe's groups are mixed first; what only keeps layers together is none."""
    return tuple(group for group in layer.groups if group.blend_mode != PASS_THROUGH)


def _entries(
    pairs: Sequence[tuple[UnpackedLayer, Mapping[str, str]]], depth: int
) -> Iterator[RecipeLayer | RecipeGroup]:
    """Layers as they stand at one depth of groups; neighbours in the same group make one entry."""

    def group_of(pair: tuple[UnpackedLayer, Mapping[str, str]]) -> WorkspaceGroup | None:
        groups = _mixed_first(pair[0])
        return groups[depth] if len(groups) > depth else None

    for _, run in itertools.groupby(pairs, lambda pair: id(group_of(pair)) if group_of(pair) else 0):
        members = list(run)
        group = group_of(members[0])
        if group is None:
            yield from (_recipe_layer(*pair) for pair in members)
            continue
        mode: LayerMode = "over" if group.blend_mode == NORMAL_BLEND else "rnm"
        options = GroupOptions(_plain(group.name) or "group", mode, _number(group.opacity))
        yield RecipeGroup(tuple(_entries(members, depth + 1)), options, hidden=not group.visible)


def _recipe_layer(layer: UnpackedLayer, entry: Mapping[str, str]) -> RecipeLayer:
    passed = [group for group in layer.groups if group.blend_mode == PASS_THROUGH]
    strength = _number(layer.strength * math.prod(group.opacity for group in passed))
    place = f"{layer.left}px,{layer.top}px"
    options = LayerOptions(
        _plain(layer.name) or "layer",
        layer.mode,  # type: ignore[arg-type]
        min(strength, 1.0) if layer.mode == "over" else strength,
        place,
        "top-left",
    )
    visible = layer.visible and all(group.visible for group in passed)
    return RecipeLayer(entry["file"], options, entry.get("mask"), hidden=not visible)


def _number(value: float) -> float:
    """As many digits as an opacity of an editor has, and some."""
    return round(float(value), 6)


def _plain(text: str) -> str:
    valid = text.encode("utf-8", "ignore").decode("utf-8")
    return "".join(c for c in valid if c.isprintable())
