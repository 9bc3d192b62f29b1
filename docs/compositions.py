"""Make the figure of composed reliefs: ``python docs/compositions.py [MESH MESH MESH] [--out FILE]``.

Upper row, from the left: two models on one plate; the details of one pasted on another; a motif on a rolling ground.
Lower row: a motif on a cylinder; two on a dodecahedron, the second of which continues its edges.
Without arguments it uses the sample meshes.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh
from make_pictures import PICTURES, SAMPLES, Picture, row, rows

import nmaptool as nm

SIDE_PX = 360
MAP_PX = 900


def bake(mesh: nm.Mesh, **camera: Any) -> nm.LayerSet:
    size = f"{MAP_PX}x{MAP_PX}"
    return nm.bake(mesh, nm.BakeOptions(size=size, **camera), nm.FilterOptions(sigma_s=2.0))


def solid(shape: trimesh.Trimesh) -> nm.NormalMap:
    mesh = nm.Mesh(np.asarray(shape.vertices, np.float64), np.asarray(shape.faces, np.int32))
    return bake(mesh, margin="2%").original


def cylinder() -> nm.NormalMap:
    upright = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
    return solid(trimesh.creation.cylinder(radius=60, height=110, sections=720, transform=upright))


def dodecahedron() -> nm.NormalMap:
    g = (1 + 5**0.5) / 2
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for a in (-1, 1):
        for b in (-1, 1):
            corners += [(0, a / g, b * g), (a / g, b * g, 0), (b * g, 0, a / g)]
    shape = trimesh.Trimesh(np.array(corners) * 40).convex_hull
    shape.apply_transform(trimesh.transformations.rotation_matrix(0.35, [1.0, 0.3, 0.1]))
    return solid(shape)


def rolling_ground(rise: float) -> nm.NormalMap:
    """A surface with rolling hills."""
    y, x = np.mgrid[0:MAP_PX, 0:MAP_PX] / MAP_PX
    p, q = rise * np.cos(18 * x + 2 * np.sin(4 * y)), rise / 3 * np.sin(9 * y)
    normals = np.dstack([-p, -q, np.ones_like(p)])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return nm.NormalMap(normals.astype(np.float32), np.ones_like(p, np.float32), nm.Frame(MAP_PX, MAP_PX, 0.1))


def layer(normal_map: nm.NormalMap, **options: Any) -> nm.Layer:
    return nm.Layer(normal_map, nm.LayerOptions(**options))


def shaded(relief: nm.Relief) -> Picture:
    return cv2.resize(nm.preview(relief.height), (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA).astype(np.uint8)


def on_plate(*layers: nm.Layer) -> Picture:
    return carved(nm.compose(layers, nm.CanvasOptions(size=f"{MAP_PX}x{MAP_PX}", ground="flat")))


def carved(composed: nm.Composition) -> Picture:
    return shaded(nm.relief(composed.normal_map, options=nm.ReliefOptions(height=nm.length("4%"))))


def on_surface(surface: nm.NormalMap, motif: nm.Layer) -> Picture:
    """A relief of the motif; the background keeps its own height."""
    composed = nm.paste(surface, [motif])
    options = nm.ReliefOptions(background="surface", beta=0.002, delta=25)
    return shaded(nm.relief(composed.normal_map, mask=composed.placed, surface=surface, options=options))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="*", type=Path, help="three meshes")
    parser.add_argument("--out", type=Path, default=PICTURES / "compositions.jpg")
    given = parser.parse_args()
    paths = given.meshes or [SAMPLES / f"{name}.ply" for name in ("portrait", "vase", "rings")]
    if len(paths) != 3:
        parser.error("give three meshes, or none")
    shading = "flat" if given.meshes else "smooth"
    first, second, third = (bake(nm.read_mesh(path), shading=shading) for path in paths)
    above = [
        on_plate(
            layer(first.original, at="29%,50%", scale=0.55), layer(second.original, at="74%,50%", scale=0.6, rotate=-8)
        ),
        carved(nm.paste(second.base, [layer(third.detail, mode="rnm", scale=1.1, feather="20px")])),
        on_surface(rolling_ground(0.5), layer(first.original, scale=0.75)),
    ]
    below = [
        on_surface(cylinder(), layer(first.original, scale=0.6)),
        on_surface(dodecahedron(), layer(third.original, scale=0.5, at="50%,48%", rotate=8)),
        on_surface(dodecahedron(), layer(second.original, scale=0.5, at="50%,48%", mode="rnm")),
    ]
    picture = rows([row(above), row(below)])
    given.out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(given.out), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main()
