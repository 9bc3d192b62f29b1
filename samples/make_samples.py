"""Make the sample maps from analytic surfaces: ``python samples/make_samples.py FOLDER``.

A rosette medal (original, base and detail layers, 16-bit with alpha), a scallop shell (8-bit on white with soft edges,
as real maps often have), and a leaf on a rolled background (the whole, the background alone, the leaf's mask).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import nmaptool as nm
from nmaptool.core.vectors import unit
from nmaptool.io.pictures.writer import write_image
from nmaptool.maps.codec import encode_codes

Array = NDArray[np.float64]
Surface = Callable[[Array, Array], Array]
SUPERSAMPLE = 4
STEP = 1e-4


def grid(rows: int, cols: int) -> tuple[Array, Array]:
    """Coordinates (x right, y up) of the supersampled pixel centres; the longer side spans -1 to 1."""
    half = max(rows, cols) / 2
    x = ((np.arange(cols * SUPERSAMPLE) + 0.5) / SUPERSAMPLE - cols / 2) / half
    y = (rows / 2 - (np.arange(rows * SUPERSAMPLE) + 0.5) / SUPERSAMPLE) / half
    return np.broadcast_to(x, (y.size, x.size)), np.broadcast_to(y[:, None], (y.size, x.size))


def pooled(fine: Array) -> Array:
    """Mean over each pixel's samples."""
    rows, cols = fine.shape[0] // SUPERSAMPLE, fine.shape[1] // SUPERSAMPLE
    return fine.reshape(rows, SUPERSAMPLE, cols, SUPERSAMPLE, *fine.shape[2:]).mean(axis=(1, 3))


def fine_normals(surface: Surface, x: Array, y: Array) -> Array:
    """Unit normals of z = surface(x, y) by central differences."""
    p = (surface(x + STEP, y) - surface(x - STEP, y)) / (2 * STEP)
    q = (surface(x, y + STEP) - surface(x, y - STEP)) / (2 * STEP)
    normals = np.stack([-p, -q, np.ones_like(p)], axis=-1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def smooth_step(value: Array, low: float, high: float) -> Array:
    """0 below ``low``, 1 above ``high``, smooth between."""
    t = ((value - low) / (high - low)).clip(0, 1)
    return t * t * (3 - 2 * t)


def petal_reach(angle: Array) -> Array:
    """Length of the petals from the centre in a direction."""
    return 0.30 + 0.42 * np.abs(np.cos(4 * angle)) ** 0.7


def medal_base(x: Array, y: Array) -> Array:
    """A rosette of eight petals around a boss, inside a raised rim."""
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    petals = 0.30 * np.sqrt((1 - (r / petal_reach(angle)) ** 2).clip(0, None) + 1e-3) * smooth_step(r, 0.12, 0.3)
    boss = 0.34 * np.sqrt((1 - (r / 0.2) ** 2).clip(0, None) + 1e-3)
    rim = 0.12 * np.sqrt((1 - ((r - 0.86) / 0.09) ** 2).clip(0, None) + 1e-3)
    return np.maximum(np.maximum(petals, boss), rim)


def medal_detail(x: Array, y: Array) -> Array:
    """Veins on the petals, a stippled boss, a cord around the rim."""
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    across = np.abs((angle * 8 / np.pi + 1) % 2 - 1)  # 0 along a petal's middle
    inside = 1 - r / petal_reach(angle)
    veins = 0.006 * np.cos(70 * r - 9 * across) * smooth_step(across, 0.04, 0.16) * smooth_step(inside, 0.02, 0.12)
    veins = veins * smooth_step(r, 0.23, 0.3)
    boss = 0.005 * np.cos(60 * x) * np.cos(60 * y) * smooth_step(0.17 - r, 0, 0.05)
    cord = 0.008 * np.cos(64 * angle + 60 * (r - 0.86)) * smooth_step(0.07 - np.abs(r - 0.86), 0, 0.04)
    return veins + boss + cord


def shell(x: Array, y: Array) -> Array:
    """A scallop: ribs that fan out from the hinge over a steep dome."""
    angle = np.arctan2(x, y + 0.85)
    radius = np.hypot(x, y + 0.85)
    dome = 0.75 * np.sqrt((1 - (x / 0.88) ** 2 - ((y + 0.02) / 0.86) ** 2).clip(0, None) + 1e-4)
    fade = smooth_step(dome, 0.02, 0.25)
    ribs = 0.035 * np.abs(np.cos(13 * angle)) * smooth_step(radius, 0.15, 0.6) * fade
    growth = 0.006 * np.cos(55 * radius) * smooth_step(radius, 0.3, 0.7) * fade
    return dome + ribs + growth


def shell_cover(x: Array, y: Array) -> Array:
    """1 on the shell, 0 beside it."""
    return ((x / 0.88) ** 2 + ((y + 0.02) / 0.86) ** 2 < 1).astype(float)


def roll(x: Array, y: Array) -> Array:
    """A background that rolls like a sheet of parchment."""
    return 0.12 * np.cos(3.4 * x + 0.6 * y)


def leaf_half_width(y: Array) -> Array:
    """Half the leaf's width at height y."""
    along = ((y + 0.8) / 1.6).clip(0, 1)
    return 1.15 * along**0.75 * (1 - along) ** 0.9


def leaf_cover(x: Array, y: Array) -> Array:
    """1 on the leaf, 0 beside it."""
    bent = x - 0.12 * np.sin(2.2 * y)
    return ((np.abs(bent) < leaf_half_width(y)) & (np.abs(y) < 0.8)).astype(float)


def leaf(x: Array, y: Array) -> Array:
    """A leaf with a midrib and side veins, standing on the rolled background."""
    bent = x - 0.12 * np.sin(2.2 * y)
    width = np.maximum(leaf_half_width(y), 1e-3)
    share = (np.abs(bent) / width).clip(0, 1)
    body = 0.20 * np.sqrt(width) * np.sqrt((1 - share**2).clip(0, None) + 1e-3)
    veins = (
        0.012 * np.cos(34 * (y - 0.9 * np.abs(bent))) * smooth_step(share, 0.06, 0.25) * smooth_step(1 - share, 0, 0.2)
    )
    midrib = -0.03 * np.exp(-((bent / 0.018) ** 2))
    return roll(x, y) + (body + veins + midrib) * leaf_cover(x, y)


def detail_by_rotation(original: Array, base: Array) -> Array:
    """The rotation that takes base to (0, 0, 1), applied to original."""
    axis = np.stack([base[..., 1], -base[..., 0], np.zeros(base.shape[:-1])], axis=-1)
    cosine = base[..., 2:]
    along = (axis * original).sum(axis=-1, keepdims=True)
    return original * cosine + np.cross(axis, original) + axis * along / (1 + cosine)


def save(path: Path, normals: Array, coverage: Array | None = None) -> None:
    rows, cols = normals.shape[:2]
    covered = np.ones((rows, cols)) if coverage is None else coverage
    vectors = unit(normals)
    vectors[covered <= 0] = (0, 0, 1)
    normal_map = nm.NormalMap(vectors, covered.astype(np.float32), nm.Frame(rows, cols))
    nm.write_normal_map(normal_map, path, overwrite=True)


def make_medal(folder: Path, side: int = 248) -> None:
    x, y = grid(side, side)
    disc = (np.hypot(x, y) < 0.955).astype(float)
    base = unit(pooled(fine_normals(medal_base, x, y))).astype(np.float64)
    original = unit(pooled(fine_normals(lambda u, v: medal_base(u, v) + medal_detail(u, v), x, y))).astype(np.float64)
    coverage = pooled(disc)
    save(folder / "medal_original.png", original, coverage)
    save(folder / "medal_base.png", base, coverage)
    save(folder / "medal_detail.png", detail_by_rotation(original, base), coverage)


def make_shell(folder: Path, side: int = 280) -> None:
    x, y = grid(side, side)
    cover = shell_cover(x, y)[..., None]
    codes = (fine_normals(shell, x, y) + 1) / 2 * cover + (1 - cover)  # an editor's soft edge on white
    picture = encode_codes((pooled(codes) * 2 - 1).astype(np.float32), 8)
    write_image(picture, folder / "shell.png", ("R", "G", "B"), {})


def make_leaf(folder: Path, side: int = 224) -> None:
    x, y = grid(side, side)
    save(folder / "leaf_on_roll.png", pooled(fine_normals(leaf, x, y)))
    save(folder / "roll.png", pooled(fine_normals(roll, x, y)))
    mask = (pooled(leaf_cover(x, y)) * 255 + 0.5).astype(np.uint8)
    write_image(mask[..., None], folder / "leaf_mask.png", ("Y",), {})


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "samples")
    folder.mkdir(parents=True, exist_ok=True)
    make_medal(folder)
    make_shell(folder)
    make_leaf(folder)
    total = sum(path.stat().st_size for path in folder.glob("*.png"))
    print(f"samples in {folder}: {total / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
