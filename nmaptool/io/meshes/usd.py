"""Read USD and USDZ with usd-core, which the extra ``usd`` installs; only layers in the same folder are opened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, NmaptoolError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers, fans
from nmaptool.io.meshes.surface import Surface
from nmaptool.io.meshes.upright import turned_y_up
from nmaptool.types.shown import counted

_SOLIDS = ("Capsule", "Cone", "Cube", "Cylinder", "Plane", "Sphere", "NurbsPatch", "BasisCurves", "Points", "Volume")


def read_usd(file: MeshFile, max_faces: int) -> Surface:
    """Read a USD or USDZ: its visible meshes in place, with y up.

    Raises
    ------
    InputError
        If usd-core is not installed, or the file is damaged, has no faces or needs layers outside its folder.
    LimitError
        If it has more than ``max_faces`` triangles; each placement of a part counts.
    """
    try:
        from pxr import Sdf, Tf, Usd, UsdUtils
    except ImportError:
        raise InputError(
            f'{file.path}: reading USD needs usd-core; pip install "nmaptool-relief[usd]", or export it as GLB, STL, '
            "OBJ or PLY"
        ) from None
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # otherwise warnings go to standard error
    try:
        _check_layers(file, Sdf.Layer.FindOrOpen(str(file.path.resolve())))
        stage = Usd.Stage.Open(str(file.path.resolve()))
        return _surface(file, stage, max_faces)
    except (NmaptoolError, MemoryError):
        raise
    except (Tf.ErrorException, ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError):
        raise file.damaged from None
    finally:
        quiet.TakeUncoalescedDiagnostics()


def _check_layers(file: MeshFile, root: Any) -> None:
    """Refuse layers outside the folder of the file before they are opened; layers in a USDZ are inside it."""
    from pxr import Sdf

    if root is None:
        raise file.damaged
    folder = file.path.parent.resolve()
    waiting, seen = [root], set[str]()
    while waiting:
        layer = waiting.pop()
        for name in layer.GetCompositionAssetDependencies():
            place = layer.ComputeAbsolutePath(name)
            if not name or place in seen:
                continue
            seen.add(place)
            target = Path(place.split("[")[0])  # inside a USDZ, its name is in brackets
            is_unknown = not target.is_absolute() and ".." not in target.parts  # USD found it nowhere
            if "://" in name or not (is_unknown or target.resolve().is_relative_to(folder)):
                raise InputError(
                    f"{file.path}: needs {name[:80]!r}, but only files in its own folder are opened; flatten it to one "
                    "file, such as with usdcat"
                )
            if is_unknown or not target.is_file():
                raise InputError(
                    f"{file.path}: needs the file {name[:80]!r} beside it, which is missing; put it there, or flatten "
                    "it to one file, such as with usdcat"
                )
            found = Sdf.Layer.FindOrOpen(place)
            if found is None:
                raise file.damaged
            waiting.append(found)


def _surface(file: MeshFile, stage: Any, max_faces: int) -> Surface:
    from pxr import Usd, UsdGeom

    time = Usd.TimeCode.EarliestTime()
    cache = UsdGeom.XformCache(time)
    points, pieces, made = list[Float64](), list[Integers](), list[Integers]()
    notes, others = list[str](), set[str]()
    count = faces = smooth = 0
    for prim in stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        kind = prim.GetTypeName()
        if kind in _SOLIDS or kind == "PointInstancer":
            others.add(str(kind))
        if not prim.IsA(UsdGeom.Mesh) or not _is_shown(prim, time):
            continue
        mesh = UsdGeom.Mesh(prim)
        vertices = np.asarray(mesh.GetPointsAttr().Get(time), np.float64).reshape(-1, 3)
        sizes = np.asarray(mesh.GetFaceVertexCountsAttr().Get(time), np.int64)
        corners = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(time), np.int64)
        if (sizes < 0).any() or sizes.sum() != len(corners):
            raise file.damaged
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
            raise file.names_missing_vertex(int(corners.max()), len(vertices))
        faces += int(np.maximum(sizes - 2, 0).sum())
        file.check_limit(faces, max_faces)
        matrix = np.array(cache.GetLocalToWorldTransform(prim))  # of row vectors
        triangles = fans(sizes, corners)
        if (mesh.GetOrientationAttr().Get() == "leftHanded") != (np.linalg.det(matrix[:3, :3]) < 0):
            triangles = triangles[:, ::-1]
        smooth += mesh.GetSubdivisionSchemeAttr().Get() != "none"
        points.append(vertices @ matrix[:3, :3] + matrix[3, :3])
        pieces.append(triangles + count)
        made.append(np.maximum(sizes - 2, 0))
        count += len(vertices)
    if not faces:
        raise file.holds_no_faces(0)
    if smooth:
        notes.append(f"took {counted(smooth, 'subdivision mesh')} as polygons")
    if others:
        notes.append(f"ignored prims of the types {', '.join(sorted(others))}")
    up = str(UsdGeom.GetStageUpAxis(stage))
    vertices = turned_y_up(np.concatenate(points), up)
    unit = 1000.0 * UsdGeom.GetStageMetersPerUnit(stage)
    return Surface(vertices, np.concatenate(pieces), np.concatenate(made), tuple(notes), mm_per_unit=unit, is_y_up=True)


def _is_shown(prim: Any, time: Any) -> bool:
    from pxr import UsdGeom

    image = UsdGeom.Imageable(prim)
    is_drawn = image.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
    return bool(is_drawn and image.ComputeVisibility(time) != UsdGeom.Tokens.invisible)
