"""Make the figures of the docs from the samples: ``python docs/make_pictures.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import nmaptool as nm
from nmaptool.core.vectors import mean_angle_deg

ROOT = Path(__file__).parents[1]
SAMPLES = ROOT / "samples"
PICTURES = ROOT / "docs" / "pictures"
GAP_PX = 6
Picture = NDArray[np.uint8]


def sample(name: str) -> nm.NormalMap:
    return nm.read_normal_map(SAMPLES / f"{name}.png")


def shaded(original: str, detail: str | None = None, side: int = 300, **changes: Any) -> Picture:
    """A square preview of a relief."""
    beside = {k: changes.pop(k) for k in ("mask", "surface") if k in changes}
    layer = sample(detail) if detail is not None else None
    relief = nm.relief(sample(original), layer, options=nm.ReliefOptions(**changes), **beside)
    return cv2.resize(nm.preview(relief.height), (side, side), interpolation=cv2.INTER_AREA).astype(np.uint8)


def row(pictures: list[Picture]) -> Picture:
    gap = np.full((pictures[0].shape[0], GAP_PX, 3), 255, np.uint8)
    parts = [part for picture in pictures for part in (picture, gap)]
    return np.hstack(parts[:-1])


def rows(pictures: list[Picture]) -> Picture:
    gap = np.full((GAP_PX, pictures[0].shape[1], 3), 255, np.uint8)
    parts = [part for picture in pictures for part in (picture, gap)]
    return np.vstack(parts[:-1])


def save(name: str, picture: Picture) -> None:
    cv2.imwrite(str(PICTURES / name), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])


def gallery() -> Picture:
    """The reliefs of ``make demo``."""
    leaf_mask = nm.read_grey(SAMPLES / "leaf_mask.png")
    roll = nm.read_normal_map(SAMPLES / "roll.png")
    return row(
        [
            shaded("medal_original", "medal_detail", mu=0.5, height=nm.length("5%")),
            shaded("medal_base", height=nm.length("5%")),
            shaded("shell", height=nm.length("8%")),
            shaded("leaf_on_roll", background="surface", mask=leaf_mask, surface=roll, height=nm.length("5%")),
        ]
    )


def parameters() -> Picture:
    """One parameter increases along each row: mu, beta, delta; rows have a common height scale."""
    layers = ("medal_original", "medal_detail")
    return rows(
        [
            row([shaded(*layers, mu=mu, beta=0.001) for mu in (0.0, 0.3, 1.0, 3.0)]),
            row([shaded(*layers, beta=beta) for beta in (0.0001, 0.001, 0.01, 0.1)]),
            row([shaded(*layers, beta=0.01, delta=delta) for delta in (0.0, 15.0, 30.0, 60.0)]),
        ]
    )


def lit(normal_map: nm.NormalMap) -> Picture:
    """A normal map under a raking light."""
    light = np.array([-0.55, 0.55, 0.63], np.float32)
    shade = (0.08 + 0.92 * (normal_map.normals @ light).clip(0, 1)) * (0.35 + 0.65 * normal_map.coverage)
    return np.repeat((shade * 255).astype(np.uint8)[..., None], 3, axis=2)


def colors(normal_map: nm.NormalMap) -> Picture:
    return ((normal_map.normals + 1) * 127.5).astype(np.uint8)


def capture(side: int = 400) -> Picture:
    """The portrait: its three maps, the relief with its detail, the relief of its structure."""
    mesh = nm.read_mesh(SAMPLES / "portrait.ply")
    camera = nm.BakeOptions(size=f"{2 * side}x{2 * side}", shading="smooth")
    layers = nm.bake(mesh, camera, nm.FilterOptions(sigma_s=2.0))
    pictures = [colors(layers.original), colors(layers.base), colors(layers.detail)]
    height = nm.length("4mm")
    for maps, mu in (((layers.original, layers.detail), 0.5), ((layers.base, None), 0.0)):
        pictures.append(nm.preview(nm.relief(*maps, options=nm.ReliefOptions(mu=mu, height=height)).height))
    return row([cv2.resize(p, (side, side), interpolation=cv2.INTER_AREA).astype(np.uint8) for p in pictures])


def smoothing(side: int = 400) -> Picture:
    """The portrait unchanged, without its detail, with half of it, with more of it."""
    mesh = nm.read_mesh(SAMPLES / "portrait.ply")
    camera, detail = nm.BakeOptions(size=f"{2 * side}x{2 * side}", shading="smooth"), nm.FilterOptions(sigma_s=1.5)
    meshes = [mesh, *(nm.smooth(mesh, nm.SmoothOptions(gain), detail).mesh for gain in (0.0, 0.5, 1.4))]
    pictures = [lit(nm.bake(each, camera, detail).original) for each in meshes]
    return row([cv2.resize(p, (side, side), interpolation=cv2.INTER_AREA).astype(np.uint8) for p in pictures])


def divided(mesh: nm.Mesh) -> nm.Mesh:
    """Divide each face into four at its edge midpoints: the same surface."""
    a, b, c = (mesh.corners[:, k] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return nm.Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3), mesh.mm_per_unit)


def refinement(side: int = 360) -> Picture:
    """Base of one surface, unchanged and with its faces divided twice: ring above, surface below."""
    mesh = nm.read_mesh(SAMPLES / "rings.ply")
    meshes = (mesh, divided(divided(mesh)))
    camera = nm.BakeOptions(size=f"{side}x{side}")
    out = []
    for neighborhood in ("ring", "surface"):
        filter = nm.FilterOptions(neighborhood=neighborhood, sigma_s=nm.length("3mm"))  # noqa: A001
        coarse, fine = (nm.bake(m, camera, filter) for m in meshes)
        moved = mean_angle_deg(*(x.base.normals[coarse.coverage == 1] for x in (coarse, fine)))
        print(f"{neighborhood}: divided twice, the base turns by {moved:.1f} degrees on average")
        out.append(row([lit(coarse.original), lit(coarse.base), lit(fine.base)]))
    return rows(out)


def seen(solid: nm.Solid, azimuth: float, elevation: float, side: int) -> Picture:
    """A solid from a camera around it, its plate upright."""
    size = f"{2 * side}x{2 * side}"
    camera = nm.BakeOptions(view="front", azimuth=azimuth, elevation=elevation, fov=25.0, size=size)
    picture = lit(nm.bake(solid.to_mesh(), camera, nm.FilterOptions(sigma_s=1.0)).original)
    return cv2.resize(picture, (side, side), interpolation=cv2.INTER_AREA).astype(np.uint8)


def solids(side: int = 360) -> Picture:
    """A pendant, the hollow back of a plaque, the portrait on its plate, the gate with upright walls."""
    width, height = nm.length("60mm"), nm.length("4mm")
    cut = nm.ReliefOptions(mu=0.5, background="cut", height=nm.length("3mm"), width=width)
    medal = nm.relief(sample("medal_original"), sample("medal_detail"), cut)
    leaf_mask, roll = nm.read_grey(SAMPLES / "leaf_mask.png"), nm.read_normal_map(SAMPLES / "roll.png")
    curved = nm.ReliefOptions(background="surface", height=height, width=width)
    leaf = nm.relief(sample("leaf_on_roll"), options=curved, mask=leaf_mask, surface=roll)
    thick, thin = (
        nm.SolidOptions(base=nm.length("3mm")),
        nm.SolidOptions(base=nm.length("4mm"), hollow=nm.length("1.2mm")),
    )
    made = [seen(nm.solid(medal, thick), 25, 25, side), seen(nm.solid(leaf, thin), 155, 25, side)]
    for name, edge in (("portrait", "blend"), ("gate", "wall")):
        layers = nm.bake(nm.read_mesh(SAMPLES / f"{name}.ply"), nm.BakeOptions(size="720x720", shading="smooth"))
        options = nm.ReliefOptions(mu=0.5, height=height, width=width, edge=edge)
        made.append(seen(nm.solid(nm.relief(layers.original, layers.detail, options), thick), 30, 25, side))
    return row(made)


if __name__ == "__main__":
    PICTURES.mkdir(exist_ok=True)
    save("gallery.jpg", gallery())
    save("parameters.jpg", parameters())
    save("capture.jpg", capture())
    save("refinement.jpg", refinement())
    save("smoothing.jpg", smoothing())
    save("solids.jpg", solids())
