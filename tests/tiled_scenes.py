"""Small maps in Zarr stores, as large maps are stored."""

from __future__ import annotations

import numpy as np

import nmaptool as nm
from nmaptool.io.stores.opening import create_picture
from nmaptool.io.stores.zarr_pictures import ZarrPicture
from nmaptool.options import TilingOptions

HERE = TilingOptions(tile=64, workers=1)


def bumps(rows, cols, seed=0, pitch_mm=0.1, motif=None):
    """A smooth random surface as a normal map; ``motif`` is where it has coverage."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:rows, :cols].astype(np.float64)
    p, q = np.zeros((2, rows, cols))
    for _ in range(6):
        across, down = rng.normal(0, 0.15, 2)
        wave = rng.normal(0, 0.25) * np.cos(across * x + down * y + rng.uniform(0, 6))
        p += across * 4 * wave
        q += down * 4 * wave
    normals = np.stack([-p, q, np.ones_like(p)], axis=-1)
    coverage = np.ones((rows, cols), np.float32) if motif is None else motif.astype(np.float32)
    return nm.NormalMap.from_array(normals, coverage, pitch_mm)


def disc(rows, cols, radius, soft=2.0, center=None):
    """(rows, cols) float32: a disc with a soft edge."""
    y, x = np.mgrid[:rows, :cols]
    cy, cx = (rows / 2, cols / 2) if center is None else center
    return np.clip((radius - np.hypot(y + 0.5 - cy, x + 0.5 - cx)) / soft + 0.5, 0, 1).astype(np.float32)


def as_store(normal_map, path, bits="float", chunk=64):
    """The name of a store with the pixels that `nmaptool.write_normal_map` writes."""
    from nmaptool.io.stores.map_output import MapLayout
    from nmaptool.options import WriteOptions

    covered = bool((normal_map.coverage < 1).any())
    frame = normal_map.frame
    layout = MapLayout(frame.rows, frame.cols, frame.pitch_mm, chunk, covered, WriteOptions(bits=bits))
    layout.create(str(path))
    layout.write(str(path), 0, 0, normal_map.normals, normal_map.coverage)
    return str(path)


def grey_store(values, path, chunk=64):
    """The name of a store with grey values."""
    values = np.asarray(values)
    create_picture(str(path), *values.shape, ("Y",), values.dtype, chunk=chunk, inner=16).write(0, 0, values)
    return str(path)


def pixels(name):
    """All stored values."""
    return ZarrPicture(name).read(slice(None), slice(None)).pixels


def whole(name, **reading):
    """A store, read and decoded as one map."""
    return nm.decode_normal_map(
        ZarrPicture(name).read(slice(None), slice(None)), nm.ReadOptions(background_color="alpha", **reading)
    )
