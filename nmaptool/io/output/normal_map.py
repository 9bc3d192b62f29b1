"""Write a normal map to a file, alone or with pictures and a report of how it was made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from nmaptool.core.errors import UsageError
from nmaptool.io.output.map_pictures import curl_image
from nmaptool.io.output.targets import Destination, Place, place_of
from nmaptool.io.output.transaction import Outputs, Target
from nmaptool.io.pictures.normal_maps import normal_picture
from nmaptool.io.pictures.writer import Picture, write_pictures
from nmaptool.options import Bits, WriteOptions
from nmaptool.options.formats import NORMAL_MAP_FORMATS, check_ending
from nmaptool.types.normal_map import NormalMap


@dataclass(frozen=True)
class WrittenMap:
    """A normal map and what is written with it.

    Parameters
    ----------
    normal_map : NormalMap
    attributes : mapping
        Additional metadata of the file, such as the recipe.
    kept : mapping
        Metadata of the map's source file; the attributes of the map override it.
    pictures : mapping of str to callable
        Functions that make the pictures, by kind, such as ``placed``; ``curl`` is always available.
    options : WriteOptions, optional
        How to write the map. Default: the options of the plan.
    """

    normal_map: NormalMap
    attributes: Mapping[str, str] = field(default_factory=dict)
    kept: Mapping[str, str] = field(default_factory=dict)
    pictures: Mapping[str, Callable[[], Picture]] = field(default_factory=dict)
    options: WriteOptions | None = None


def check_map_target(place: Place, options: WriteOptions) -> None:
    """Refuse an extension that is not supported for normal maps, or bits that its format cannot hold.

    Raises
    ------
    UsageError
    """
    check_ending(place, NORMAL_MAP_FORMATS, "normal maps")
    ending = place.suffix.lower()
    offered = NORMAL_MAP_FORMATS[ending].bits
    if options.bits not in ("auto", *offered):
        raise UsageError(f"{place}: `bits={options.bits!r}` is not supported for {ending}; use {' or '.join(offered)}")


def bits_of(place: Place, options: WriteOptions) -> Bits:
    """Return the bits of a normal map at this place: "8", "16", "half" or "float"."""
    check_map_target(place, options)
    return NORMAL_MAP_FORMATS[place.suffix.lower()].bits[0] if options.bits == "auto" else options.bits


def map_outputs(
    output: Destination,
    options: WriteOptions | None = None,
    *,
    pictures: Mapping[str, Destination | None] | None = None,
    report: Destination | None = None,
    overwrite: bool = False,
) -> Outputs[WrittenMap]:
    """The plan of a normal map with pictures, .png, by kind: ``curl``, ``placed``, ..."""
    place, options = place_of(output), options or WriteOptions()
    targets = [Target(place, "normal maps", NORMAL_MAP_FORMATS, partial(_write_map, options))]
    for kind, picture in (pictures or {}).items():
        if picture is not None:
            write = partial(_write_picture, kind)
            targets.append(Target(place_of(picture), f"the {kind} picture", (".png",), write))
    return Outputs(targets, place_of(report), overwrite, rules=[partial(check_map_target, place, options)])


def write_normal_map(
    normal_map: NormalMap,
    path: Destination,
    options: WriteOptions | None = None,
    *,
    attributes: Mapping[str, str] | None = None,
    overwrite: bool = False,
) -> None:
    """Write a normal map; coverage is stored as unassociated alpha, the convention and pitch as metadata.

    Parameters
    ----------
    normal_map : NormalMap
    path : str, Path or OutputStream
        ``.png``, ``.tif`` (integer codes) or ``.exr`` (signed floats).
    options : WriteOptions, optional
    attributes : mapping, optional
        Additional metadata, such as the recipe.
    overwrite : bool
        Replace a file that exists.

    Raises
    ------
    UsageError
        If the extension or the bits are not supported.
    OutputError
        If it cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> flat = np.full((32, 48, 3), (0.0, 0, 1))
    >>> nm.write_normal_map(nm.NormalMap.from_array(flat, pitch_mm=0.5), "flat.png")
    >>> nm.read_normal_map("flat.png", nm.ReadOptions(background_color="none"))
    <NormalMap flat.png: 48 x 32 px, 0.5 mm per px, 100% covered>
    """
    map_outputs(path, options, overwrite=overwrite).write(WrittenMap(normal_map, attributes or {}))


def _write_map(planned: WriteOptions, written: WrittenMap, path: Path) -> None:
    options = written.options or planned
    added = NORMAL_MAP_FORMATS[path.suffix.lower()].write
    if added is not None:
        added(written.normal_map, path, options, {**written.kept, **written.attributes})
        return
    picture = _map_picture(written.normal_map, bits_of(path, options), options)
    facts = {**written.kept, **picture.attributes, **written.attributes}
    write_pictures([replace(picture, attributes=facts)], path)


def _map_picture(normal_map: NormalMap, bits: Bits, options: WriteOptions) -> Picture:
    depth = 32 if bits in ("half", "float") else int(bits)
    zero_code = "127.5" if options.write_zero_code == "auto" else options.write_zero_code
    return normal_picture(normal_map, depth, half=bits == "half", green=options.write_green, zero_code=zero_code)


def _write_picture(kind: str, written: WrittenMap, path: Path) -> None:
    known: dict[str, Callable[[], Picture]] = {"curl": partial(curl_image, written.normal_map), **written.pictures}
    write_pictures([known[kind]()], path)
