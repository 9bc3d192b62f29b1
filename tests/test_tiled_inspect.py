"""Large maps are measured by tiles as whole maps are."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from tiled_scenes import HERE, as_store, bumps, disc, grey_store, pixels, whole

import nmaptool as nm
from nmaptool.core.errors import InputError
from nmaptool.io.stores.normal_maps import open_normal_map
from nmaptool.io.stores.opening import create_picture
from nmaptool.io.stores.zarr_pictures import ZarrPicture

pytest.importorskip("zarr")
ROWS, COLS = 150, 210


def codes_store(codes, path, **attributes):
    channels = ("R", "G", "B", "A")[: codes.shape[2]]
    writer = create_picture(
        str(path), *codes.shape[:2], channels, codes.dtype, chunk=64, inner=16, attributes=attributes
    )
    writer.write(0, 0, codes)
    return str(path)


def test_measurements_are_those_of_the_whole(tmp_path):
    name = as_store(bumps(ROWS, COLS, 1, motif=disc(ROWS, COLS, 70)), tmp_path / "map.zarr", "8")
    values = pixels(name).copy()
    values[60:90, 50:130, :3] = values[60:90, 50:130, :3] * 0.8 + 25  # shorter vectors
    values[100:104, 100:140, 2] = 40  # face away
    facts = {"kind": "normal", "green": "up", "zero_code": "127.5"}
    name = codes_store(values, tmp_path / "worse.zarr", **facts)
    picture = nm.RasterImage(values, ("R", "G", "B", "A"), attributes=facts)
    mask = disc(ROWS, COLS, 60)
    mask_name = grey_store((mask * 255).astype(np.uint8), tmp_path / "mask.zarr")
    for chosen, file in ((None, None), (np.round(mask * 255) / 255, mask_name)):
        seen = nm.tiled.inspect(name, mask=file, tiling=HERE)
        expected = nm.inspect_map(picture, mask=chosen)
        found = seen.inspection
        for word in ("foreground_share", "coverage_mean", "unit_length_error", "off_length_share", "away_share"):
            assert getattr(found, word) == pytest.approx(getattr(expected, word), rel=1e-6), word
        assert found.mean_abs_curl == pytest.approx(expected.mean_abs_curl, rel=0.1)
        assert [f.code for f in seen.findings] == [f.code for f in expected.findings] == ["facing-away", "off-length"]
        assert (seen.tiles, seen.unreadable, seen.chunk) == (12, 0, (64, 64))
    assert seen.to_dict()["inspection"]["rows"] == ROWS


def test_a_clean_map_has_no_findings(tmp_path):
    name = as_store(bumps(ROWS, COLS, 1), tmp_path / "map.zarr", "16")
    seen = nm.tiled.inspect(name, tiling=HERE)
    assert seen.findings == ()
    assert "0 unreadable tiles of 12" in repr(seen)


def test_what_cannot_be_read_is_told_and_the_rest_is_measured(tmp_path):
    values = whole(as_store(bumps(ROWS, COLS, 1), tmp_path / "map.zarr")).normals.copy()
    values[70, 140] = np.nan
    name = codes_store(values, tmp_path / "gaps.zarr", kind="normal", green="up", encoding="signed")
    shutil.rmtree(tmp_path / "gaps.zarr/c/0/0", ignore_errors=True)
    (tmp_path / "gaps.zarr/c/2/3/0").unlink()
    with pytest.raises(InputError):  # the sample of a small map is all of it
        nm.tiled.inspect(name, tiling=HERE)


def test_missing_chunks_of_a_large_map_are_found(tmp_path, monkeypatch):
    size = 2304
    codes = np.empty((size, size, 3), np.uint8)
    codes[...] = (127, 127, 255)
    codes[::16, ::16] = (140, 120, 254)
    writer = create_picture(
        str(tmp_path / "map.zarr"), size, size, ("R", "G", "B"), np.uint8, chunk=64, inner=64,
        attributes={"kind": "normal", "green": "up", "zero_code": "127"},
    )  # fmt: skip
    writer.write(0, 0, codes)
    looked = np.zeros((size // 64, size // 64), bool)
    read = ZarrPicture.read

    def logged(self, rows, cols):
        looked[rows.start // 64 : -(-rows.stop // 64), cols.start // 64 : -(-cols.stop // 64)] = True
        return read(self, rows, cols)

    with monkeypatch.context() as patch:
        patch.setattr(ZarrPicture, "read", logged)
        open_normal_map(str(tmp_path / "map.zarr"))
    row, col = np.argwhere(~looked)[0]  # the sample could not be read without its chunks
    (tmp_path / f"map.zarr/c/{row}/{col}/0").unlink()
    seen = nm.tiled.inspect(str(tmp_path / "map.zarr"), tiling=nm.TilingOptions(tile=256, workers=1))
    assert seen.unreadable == 1
    assert seen.findings[0].code == "unreadable"
    assert "1 of 81 tiles cannot be read; the first: " in seen.findings[0].message
    assert f"the chunk c/{row}/{col}/0 is missing" in seen.problems[0]
    assert seen.inspection.foreground_share == 1


def test_masks_that_do_not_fit_are_refused(tmp_path):
    name = as_store(bumps(ROWS, COLS, 1), tmp_path / "map.zarr", "16")
    with pytest.raises(InputError, match=r"is 210 x 150 pixels but the mask is 6 x 5; make them the same size"):
        nm.tiled.inspect(name, mask=grey_store(np.full((5, 6), 255, np.uint8), tmp_path / "tiny.zarr"), tiling=HERE)
    black = grey_store(np.zeros((ROWS, COLS), np.uint8), tmp_path / "black.zarr")
    with pytest.raises(InputError, match=r"the mask selects nothing: paint the motif white"):
        nm.tiled.inspect(name, mask=black, tiling=HERE)
