"""Large maps are blended by tiles as whole maps are."""

from __future__ import annotations

import numpy as np
import pytest
from tiled_scenes import HERE, as_store, bumps, disc, grey_store, pixels, whole

import nmaptool as nm
from nmaptool.core.errors import InputError, OutputError, UsageError

pytest.importorskip("zarr")
ROWS, COLS = 150, 210
FLOAT = nm.WriteOptions(bits="float")


@pytest.fixture
def maps(tmp_path):
    base = bumps(ROWS, COLS, 1, motif=disc(ROWS, COLS, 70))
    # whole in some tiles, with soft edges in others
    detail = bumps(ROWS, COLS, 2, motif=disc(ROWS, COLS, 90, 30, (90, 120)))
    return as_store(base, tmp_path / "base.zarr"), as_store(detail, tmp_path / "detail.zarr")


@pytest.mark.parametrize("mode", list(nm.BLEND_MODES))
@pytest.mark.parametrize("strength", [0.7, 1.0])
def test_every_mode_works_on_single_pixels(tmp_path, maps, mode, strength):
    options = nm.BlendOptions(mode=mode, strength=strength)
    mask = disc(ROWS, COLS, 50, 20, (60, 80)) if strength == 1 else None
    name = None if mask is None else grey_store(mask, tmp_path / "mask.zarr")
    done = nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), options, mask=name, writing=FLOAT, tiling=HERE)
    expected = nm.blend(whole(maps[0]), whole(maps[1]), options, mask=mask)
    stored = pixels(done.output)
    assert np.array_equal(stored[..., :3], expected.normal_map.normals)
    assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
    assert done.report.layers[0]["share"] == pytest.approx(expected.report.layers[0]["share"])
    assert done.report.curl_after == pytest.approx(expected.report.curl_after, rel=0.05)
    assert (done.tiles, done.overlap, done.workers) == (12, 0, 0)


@pytest.mark.parametrize("bits", ["auto", "8", "16", "half"])
def test_codes_are_those_of_a_file(tmp_path, maps, bits):
    writing = nm.WriteOptions(bits=bits, write_green="down", write_zero_code="127.5")
    nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), writing=writing, tiling=HERE)
    expected = nm.blend(whole(maps[0]), whole(maps[1])).normal_map
    ending = ".exr" if bits == "half" else ".png"
    nm.write_normal_map(expected, tmp_path / f"out{ending}", writing)
    assert np.array_equal(pixels(str(tmp_path / "out.zarr")), nm.read_raster(tmp_path / f"out{ending}").pixels)
    back = nm.tiled.blend(str(tmp_path / "out.zarr"), maps[1], str(tmp_path / "again.zarr"), tiling=HERE)
    assert back.inputs[0].decoding.green == "down"


def test_a_large_map_and_an_ordinary_file_are_blended(tmp_path, maps):
    nm.write_normal_map(whole(maps[1]), tmp_path / "detail.exr")
    nm.tiled.blend(maps[0], str(tmp_path / "detail.exr"), str(tmp_path / "a.zarr"), tiling=HERE)
    nm.tiled.blend(*maps, str(tmp_path / "b.zarr"), tiling=HERE)
    assert np.array_equal(pixels(str(tmp_path / "a.zarr")), pixels(str(tmp_path / "b.zarr")))


def test_a_stopped_run_goes_on_where_it_was(tmp_path, maps, monkeypatch):
    output = str(tmp_path / "out.zarr")
    done = []

    def stop(_, share):
        done.append(share)
        if share > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nm.tiled.blend(*maps, output, tiling=HERE, progress=stop)
    assert not (tmp_path / "out.zarr").exists()
    again = nm.tiled.blend(*maps, output, tiling=HERE)
    assert again.resumed == len([share for share in done if share]) >= 4
    fresh = nm.tiled.blend(*maps, str(tmp_path / "fresh.zarr"), tiling=HERE)
    assert fresh.resumed == 0
    assert np.array_equal(pixels(output), pixels(fresh.output))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["base.zarr", "detail.zarr", "fresh.zarr", "out.zarr"]


def test_other_options_start_again(tmp_path, maps):
    output = str(tmp_path / "out.zarr")

    def stop(_, share):
        if share > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nm.tiled.blend(*maps, output, tiling=HERE, progress=stop)
    again = nm.tiled.blend(*maps, output, nm.BlendOptions(mode="pd"), tiling=HERE)
    assert again.resumed == 0


def test_what_cannot_be_blended_is_refused(tmp_path, maps):
    small = as_store(bumps(100, 90, 3), tmp_path / "small.zarr")
    with pytest.raises(InputError, match=r"small.zarr is 90 x 100, but .*base.zarr is 210 x 150; large maps are"):
        nm.tiled.blend(maps[0], small, str(tmp_path / "out.zarr"), tiling=HERE)
    black = grey_store(np.zeros((ROWS, COLS), np.uint8), tmp_path / "black.zarr")
    with pytest.raises(InputError, match=r"black.zarr: the mask of .*detail.zarr is entirely black"):
        nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), mask=black, tiling=HERE)
    assert not list(tmp_path.glob("out*"))
    wide = grey_store(np.full((ROWS, COLS), 3, np.float32), tmp_path / "wide.zarr")
    with pytest.raises(InputError, match=r"wide.zarr: the mask of .* must lie between 0 and 1, but holds 3 to 3"):
        nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), mask=wide, tiling=HERE)
    tiny = grey_store(np.full((5, 6), 255, np.uint8), tmp_path / "tiny.zarr")
    with pytest.raises(InputError, match=r"tiny.zarr: the mask of .* is 6 x 5, expected 210 x 150"):
        nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), mask=tiny, tiling=HERE)
    with pytest.raises(UsageError, match=r"out.png: a blended map is written to a Zarr store, such as -o map.zarr"):
        nm.tiled.blend(*maps, str(tmp_path / "out.png"), tiling=HERE)
    with pytest.raises(OutputError, match=r"base.zarr: already exists"):
        nm.tiled.blend(*maps, maps[0], tiling=HERE)
    with pytest.raises(UsageError, match=r"base.zarr: is also an input; give another name"):
        nm.tiled.blend(*maps, maps[0], tiling=HERE, overwrite=True)
    with pytest.raises(OutputError, match=r"the folder .*nowhere does not exist"):
        nm.tiled.blend(*maps, str(tmp_path / "nowhere/out.zarr"), tiling=HERE)


def test_maps_that_do_not_overlap_are_told(tmp_path):
    left, right = np.zeros((2, 70, 140), np.float32)
    left[:, :50], right[:, 90:] = 1, 1
    names = [as_store(bumps(70, 140, 1, motif=m), tmp_path / f"{k}.zarr") for k, m in enumerate((left, right))]
    done = nm.tiled.blend(*names, str(tmp_path / "out.zarr"), tiling=HERE)
    assert any("does not overlap" in warning for warning in done.report.warnings)


def test_two_workers_write_the_same_bytes(tmp_path, maps):
    pytest.importorskip("distributed")
    two = nm.tiled.blend(*maps, str(tmp_path / "two.zarr"), tiling=nm.TilingOptions(tile=128, workers=2))
    one = nm.tiled.blend(*maps, str(tmp_path / "one.zarr"), tiling=nm.TilingOptions(tile=128, workers=1))
    assert (two.workers, one.workers) == (2, 0)
    files = sorted(path.relative_to(two.output) for path in (tmp_path / "two.zarr").rglob("*") if path.is_file())
    assert len(files) == 5
    for file in files:
        assert (tmp_path / "two.zarr" / file).read_bytes() == (tmp_path / "one.zarr" / file).read_bytes()


def test_an_input_that_was_replaced_is_opened_again(tmp_path, maps):
    nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), tiling=HERE)
    for name, seed in zip(maps, (7, 8), strict=True):
        as_store(bumps(80, 100, seed), name, chunk=128)
    nm.tiled.blend(*maps, str(tmp_path / "out.zarr"), writing=FLOAT, tiling=HERE, overwrite=True)
    expected = nm.blend(whole(maps[0]), whole(maps[1])).normal_map
    assert np.array_equal(pixels(str(tmp_path / "out.zarr"))[..., :3], expected.normals)
