"""Dask arrays of stores, and stores of Dask arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.options import ReliefOptions, TilingOptions
from tests.tiled_cases import store, waves

da = pytest.importorskip("dask.array")
pytest.importorskip("zarr")


@pytest.mark.parametrize("channels", [("Y",), ("R", "G", "B")])
def test_an_array_comes_back_as_it_was(tmp_path: Path, channels: tuple[str, ...]) -> None:
    values = np.random.default_rng(0).integers(0, 65535, (150, 210, len(channels))).astype(np.uint16)
    values = values[..., 0] if len(channels) == 1 else values
    name = str(tmp_path / "a.zarr")
    nm.tiled.write_array(da.from_array(values, chunks=70), name, channels, chunk=128, pitch_mm=0.5)
    found = nm.tiled.read_array(name)
    assert found.shape == values.shape
    assert found.dtype == np.uint16
    assert len(found.chunks[0]) > 1
    np.testing.assert_array_equal(found.compute(scheduler="synchronous"), values)


def test_heights_are_read_as_an_array(tmp_path: Path) -> None:
    name = store(tmp_path / "map.zarr", waves(128, 192), ("R", "G", "B"), attributes={"kind": "normal"})
    options = ReliefOptions(background="free", height=nm.length("2mm"))
    nm.tiled.relief(name, str(tmp_path / "h.zarr"), options, tiling=TilingOptions(tile=64, workers=0), at="corners")
    z = nm.tiled.read_array(str(tmp_path / "h.zarr"))
    assert float((z.max() - z.min()).compute(scheduler="synchronous")) == pytest.approx(2, rel=1e-6)


def test_channels_must_fit(tmp_path: Path) -> None:
    with pytest.raises(nm.UsageError, match=r"`channels=\('Y',\)`: an array of shape \(4, 4, 3\) has 3 channels"):
        nm.tiled.write_array(np.zeros((4, 4, 3), np.uint8), str(tmp_path / "a.zarr"), ("Y",))
