"""Output formats by file ending: one table for each kind of output.

Help texts, error messages and writers use these tables, so one entry adds a format, also at run time:
``NORMAL_MAP_FORMATS[".xyz"] = MapFormat("my format", write, bits=("8",))``. `nmaptool.io` writes the
formats whose entry has no writer. Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from nmaptool.core.errors import UsageError
from nmaptool.options.write import Bits


@dataclass(frozen=True)
class FileFormat:
    """A file format for heights or a mesh.

    Parameters
    ----------
    description : str
        What the file holds, in one line.
    write : callable, optional
        ``write(height, path, attributes)`` for heights: a `nmaptool.Height` and a mapping of metadata from str to str.
        ``write(mesh, path)`` for a `nmaptool.Mesh`. Default: the format is one of nmaptool's own.
    """

    description: str
    write: Callable[..., object] | None = None


@dataclass(frozen=True)
class MapFormat(FileFormat):
    """A file format for normal maps: ``write(normal_map, path, options, attributes)``.

    The arguments are a `nmaptool.NormalMap`, a path, a `nmaptool.WriteOptions` and a mapping of metadata from str to
    str. By default OpenImageIO writes the file, which is then read back.

    Parameters
    ----------
    bits : tuple of str
        The accepted values of ``WriteOptions.bits``, the default first: "8", "16", "half", "float".
    """

    bits: tuple[Bits, ...] = field(kw_only=True)


@dataclass(frozen=True)
class WorkspaceFormat(FileFormat):
    """A layered file format for workspaces: ``write(workspace, path)``.

    Parameters
    ----------
    bits : tuple of int
        Bits per channel that the format can hold; 32 for floats.
    """

    bits: tuple[int, ...] = field(kw_only=True)


NORMAL_MAP_FORMATS: dict[str, MapFormat] = {
    ".png": MapFormat("16- or 8-bit codes", bits=("16", "8")),
    ".exr": MapFormat("signed floats, 32 or 16 bits (half)", bits=("float", "half")),
    ".tif": MapFormat("16- or 8-bit codes, or signed floats", bits=("16", "8", "float")),
    ".tiff": MapFormat("the same as .tif", bits=("16", "8", "float")),
}
HEIGHT_FORMATS: dict[str, FileFormat] = {
    ".exr": FileFormat("heights in mm, 32-bit floats"),
    ".tif": FileFormat("heights in mm, 32-bit floats"),
    ".tiff": FileFormat("the same as .tif"),
    ".npy": FileFormat("heights in mm, 64-bit floats, NaN outside the surface"),
    ".png": FileFormat("heights as 16-bit codes, with their range in mm in the metadata"),
}
MESH_FORMATS: dict[str, FileFormat] = {
    ".stl": FileFormat("triangles in mm, binary"),
    ".ply": FileFormat("triangles in mm, binary"),
    ".obj": FileFormat("triangles in mm, text"),
    ".glb": FileFormat("triangles in metres"),
    ".3mf": FileFormat("triangles in mm, with unit, title and thumbnail, for 3D printing"),
}
# a relief is written as heights or as a mesh: a view of both tables, where heights take precedence
RELIEF_FORMATS: Mapping[str, FileFormat] = ChainMap(MESH_FORMATS, HEIGHT_FORMATS)
# a relief of a large map is written to a store, and from there to other files
LARGE_ENDING = ".zarr"
LARGE_RELIEF_FORMATS: Mapping[str, FileFormat] = {
    LARGE_ENDING: FileFormat("heights in mm, 32-bit floats, for maps larger than memory")
}
WORKSPACE_FORMATS: dict[str, WorkspaceFormat] = {
    ".psd": WorkspaceFormat("Photoshop and most editors", bits=(8, 16)),
    ".psb": WorkspaceFormat("Photoshop, for very large pictures", bits=(8, 16)),
    ".ora": WorkspaceFormat("OpenRaster: Krita, GIMP, MyPaint", bits=(8, 16)),
    ".tif": WorkspaceFormat("a page for each layer", bits=(8, 16)),
    ".tiff": WorkspaceFormat("the same as .tif", bits=(8, 16)),
    ".exr": WorkspaceFormat("a part for each layer, floats", bits=(32,)),
}
# formats of a folder of layers, without the dot, as --format takes them; True if they hold floats
LAYER_FORMATS: dict[str, bool] = {"exr": True, "png": False}


RECIPE_ENDING = ".toml"


class _HasEnding(Protocol):
    """A path, or an object that represents a file."""

    @property
    def suffix(self) -> str: ...


def check_ending(place: _HasEnding, endings: Collection[str], what: str) -> None:
    """Refuse a file ending that is not in ``endings``; ``what`` names the output, such as "a preview" or "normal maps".

    Raises
    ------
    UsageError
    """
    if place.suffix.lower() in endings:
        return
    found = f"ends in {place.suffix}; " if place.suffix else "has no ending; "
    verb = "is" if what.startswith(("a ", "an ", "the ")) else "are"
    raise UsageError(f"{place}: {found if len(endings) > 1 else ''}{what} {verb} written as {', '.join(endings)}")


def is_recipe(name: str) -> bool:
    """Whether a file name is that of a recipe."""
    return name.lower().endswith(RECIPE_ENDING)
