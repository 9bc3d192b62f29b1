"""Read whatever a preview can show: heights, normal maps, meshes and recipes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from nmaptool.core.progress import Progress
from nmaptool.io.meshes.headers import NAMES
from nmaptool.io.meshes.reader import read_mesh
from nmaptool.io.pictures.height_arrays import is_height_array
from nmaptool.io.pictures.heights import height_of_picture, read_height
from nmaptool.io.pictures.normal_maps import read_raster, split_layer
from nmaptool.maps.decoding import decode_normal_map
from nmaptool.options import MeshReadOptions, ReadOptions
from nmaptool.options.formats import is_recipe
from nmaptool.types.height import DEFAULT_LONGER_SIDE_MM, Height
from nmaptool.types.mesh import Mesh
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame, RasterImage
from nmaptool.types.relief import Relief

_MESHES = {f".{kind}" for kind in (*NAMES, "usda", "usdc", "usdz")}
Previewed: TypeAlias = Height | Relief | NormalMap | Mesh


@dataclass(frozen=True)
class PreviewSource:
    """Something that a preview can show, and what was assumed about it.

    Attributes
    ----------
    value : Height, Relief, NormalMap or Mesh
    notes : tuple of str
        One clause each, such as "100 mm wide (assumed)".
    """

    value: Previewed
    notes: tuple[str, ...] = ()


def read_previewed(
    path: str | Path,
    reading: ReadOptions | None = None,
    meshes: MeshReadOptions | None = None,
    *,
    width_mm: float | None = None,
    progress: Progress | None = None,
) -> PreviewSource:
    """Read a file for `nmaptool.preview`: its ending and its content say what it is.

    Parameters
    ----------
    path : str or Path
        A height file, a normal map, a mesh, or a recipe (.toml), which is solved.
    reading, meshes : optional
        How pictures and meshes are read.
    width_mm : float, optional
        Width of a height file that does not state the size of its pixels. Default: 100 mm on its longer side.
    progress : callable, optional
        Called with the stage and the share done, 0 to 1.

    Returns
    -------
    PreviewSource

    Raises
    ------
    InputError, LimitError
        If it cannot be read.

    Examples
    --------
    >>> np.save("dome.npy", np.zeros((40, 50)))
    >>> nm.read_previewed("dome.npy").notes
    ('100 mm wide (assumed)',)
    """
    reading, meshes = reading or ReadOptions(), meshes or MeshReadOptions()
    name = str(path)
    if is_recipe(name):
        return _solved(name, reading, progress)
    if Path(name).suffix.lower() in _MESHES:
        mesh = read_mesh(name, unit=meshes.unit, max_faces=meshes.max_faces)
        note = f"1 unit is {mesh.mm_per_unit:g} mm ({mesh.unit_from})"
        return PreviewSource(mesh, (note, *mesh.notes))
    if Path(name).suffix.lower() == ".npy" and is_height_array(Path(name)):
        height = read_height(name, pitch_mm=1.0, max_megapixels=reading.max_megapixels, with_gaps=True)
        return _sized(height, None, width_mm)
    image = read_raster(name, reading)
    if "R" not in image.channels:
        plain = height_of_picture(Path(split_layer(name)[0]), image, image.frame.pitch_mm or 1.0, with_gaps=True)
        return _sized(plain, image, width_mm)
    normal_map = decode_normal_map(image, reading)
    return PreviewSource(normal_map, ("a normal map, integrated with the usual options of nmap relief",))


def _sized(height: Height, image: RasterImage | None, width_mm: float | None) -> PreviewSource:
    """A height field with its size in mm, and how it is known."""
    if image is not None and image.frame.pitch_mm is not None:
        return PreviewSource(height)
    frame = height.frame
    side = frame.longer_side if width_mm is None else frame.cols
    pitch = (DEFAULT_LONGER_SIDE_MM if width_mm is None else width_mm) / side
    found = f"{frame.cols * pitch:.4g} mm wide ({'assumed' if width_mm is None else 'given'})"
    return PreviewSource(Height(height.z_mm, height.domain, Frame(frame.rows, frame.cols, pitch)), (found,))


def _solved(name: str, reading: ReadOptions, progress: Progress | None) -> PreviewSource:
    from nmaptool.io.recipes.scenes import read_scene

    return PreviewSource(read_scene(name, reading, progress=progress).solve(progress))
