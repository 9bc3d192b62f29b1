"""Layers are pasted on large maps by tiles as on whole maps."""

from __future__ import annotations

import numpy as np
import pytest
from tiled_scenes import HERE, as_store, bumps, disc, grey_store, pixels, whole

import nmaptool as nm
from nmaptool.core.errors import InputError, LimitError, OutputError, UsageError

pytest.importorskip("zarr")
ROWS, COLS = 170, 230
FLOAT = nm.WriteOptions(bits="float")


@pytest.fixture
def maps(tmp_path):
    plate = bumps(ROWS, COLS, 1, motif=disc(ROWS, COLS, 100, 6))
    motif = bumps(90, 110, 2, motif=disc(90, 110, 40, 8))
    return as_store(plate, tmp_path / "plate.zarr"), as_store(motif, tmp_path / "motif.zarr")


def compared(tmp_path, maps, options, mask=None, **more):
    """The result by tiles and in memory."""
    name = None if mask is None else grey_store(mask, tmp_path / "mask.zarr")
    file = nm.LayerFile(maps[1], options, name)
    done = nm.tiled.paste(maps[0], [file], str(tmp_path / "out.zarr"), writing=FLOAT, tiling=HERE, **more)
    expected = nm.paste(whole(maps[0]), [nm.Layer(whole(maps[1]), options, mask)])
    return done, expected


CASES = {
    "moved": {"at": "31px,17px", "anchor": "top-left"},
    "quarter turn": {"rotate": 90, "at": "40%,60%"},
    "half turn, mirrored": {"rotate": 180, "flip_h": True},
    "three quarters, mirrored": {"rotate": 270, "flip_v": True, "at": "0px,0px", "anchor": "top-left"},
    "over the edge": {"at": "95%,20%", "feather": nm.LayerOptions(feather="13px").feather},
    "feathered": {"feather": nm.LayerOptions(feather="20px").feather, "at": "52%,47%"},
    "hung over a corner": {"at": "-5px,-8px", "feather": nm.LayerOptions(feather="30px").feather},
    "half strength": {"strength": 0.5, "edge": "wall"},
    "added": {"mode": "pd", "strength": 0.7, "at": "20%,30%"},
    "added beyond": {"mode": "rnm", "clip": "no", "at": "10%,10%"},
    "overlaid": {"mode": "overlay", "height_factor": 2.0},
    "turned": {"rotate": 27, "feather": nm.LayerOptions(feather="9px").feather},
    "enlarged": {"scale": "1.7", "mode": "whiteout"},
    "shrunk": {"scale": "0.4", "at": "30%,60%"},
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("masked", [False, True])
def test_pixels_are_those_of_the_whole(tmp_path, maps, case, masked):
    mask = disc(90, 110, 30, 20, (40, 60)) if masked else None
    done, expected = compared(tmp_path, maps, nm.LayerOptions(**CASES[case]), mask)
    stored = pixels(done.output)
    assert np.array_equal(stored[..., :3], expected.normal_map.normals)
    assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
    own, other = done.report.layers[0], expected.report.layers[0]
    assert own["box_px"] == other["box_px"]
    assert own["share"] == pytest.approx(other["share"], rel=1e-6)


def test_several_layers_and_the_pictures_beside(tmp_path, maps):
    options = nm.LayerOptions(at="30%,30%", edge="wall"), nm.LayerOptions(at="60%,60%", rotate=10, name="turned")
    files = [nm.LayerFile(maps[1], one) for one in options]
    beside = {"placed": str(tmp_path / "placed.zarr"), "walls": str(tmp_path / "walls.zarr")}
    done = nm.tiled.paste(maps[0], files, str(tmp_path / "out.zarr"), writing=FLOAT, tiling=HERE, **beside)
    expected = nm.paste(whole(maps[0]), [nm.Layer(whole(maps[1]), one) for one in options])
    assert np.array_equal(pixels(done.output)[..., :3], expected.normal_map.normals)
    for name, values in (("placed", expected.placed), ("walls", expected.walls)):
        assert np.array_equal(pixels(beside[name])[..., 0], np.floor(values.astype(np.float64) * 255 + 0.5))
    assert [layer["name"] for layer in done.report.layers] == [maps[1], "turned"]


def test_only_the_tiles_that_a_layer_touches_are_composed(tmp_path, maps):
    done, _ = compared(tmp_path, maps, nm.LayerOptions(at="0px,0px", anchor="top-left"))
    assert (done.tiles, done.touched) == (12, 4)
    done = nm.tiled.paste(
        maps[0],
        [nm.LayerFile(maps[1], nm.LayerOptions(at="50%,50%", feather="8px"))],
        str(tmp_path / "soft.zarr"),
        tiling=HERE,
    )
    assert done.overlap == 9


def test_an_ordinary_file_keeps_its_flat_background_out(tmp_path, maps):
    medal = "samples/medal_original.png"
    options = nm.LayerOptions(scale="0.5", at="40%,50%")
    nm.tiled.paste(maps[0], [nm.LayerFile(medal, options)], str(tmp_path / "out.zarr"), writing=FLOAT, tiling=HERE)
    expected = nm.paste(whole(maps[0]), [nm.Layer(nm.read_normal_map(medal), options)])
    assert np.array_equal(pixels(str(tmp_path / "out.zarr"))[..., :3], expected.normal_map.normals)


def test_a_stopped_run_goes_on(tmp_path, maps):
    options = nm.LayerOptions(rotate=15)

    def stop(_, share):
        if share > 0.4:
            raise KeyboardInterrupt

    arguments = maps[0], [nm.LayerFile(maps[1], options)], str(tmp_path / "out.zarr")
    with pytest.raises(KeyboardInterrupt):
        nm.tiled.paste(*arguments, tiling=HERE, progress=stop)
    assert nm.tiled.paste(*arguments, tiling=HERE).resumed >= 5
    fresh = nm.tiled.paste(*arguments[:2], str(tmp_path / "fresh.zarr"), tiling=HERE)
    assert np.array_equal(pixels(arguments[2]), pixels(fresh.output))


def test_what_cannot_be_pasted_is_refused(tmp_path, maps):
    def pasted(options, mask=None, **more):
        file = nm.LayerFile(maps[1], options, mask)
        nm.tiled.paste(maps[0], [file], str(tmp_path / "out.zarr"), tiling=HERE, **more)

    with pytest.raises(UsageError, match="no layers given: add one or more after the background"):
        nm.tiled.paste(maps[0], [], str(tmp_path / "out.zarr"))
    with pytest.raises(InputError, match=r"motif.zarr: its area from 1085,425 to 1195,515 px is outside the canvas"):
        pasted(nm.LayerOptions(at="1140px,470px"))
    with pytest.raises(InputError, match=r'motif.zarr: mode "pd" needs a surface below it, found none'):
        pasted(nm.LayerOptions(mode="pd", at="-15px,-15px"))
    with pytest.raises(InputError, match=r"motif.zarr: covers no pixel of the canvas; check its mask"):
        pasted(nm.LayerOptions(), grey_store(np.zeros((90, 110), np.uint8), tmp_path / "black.zarr"))
    assert not list(tmp_path.glob("out*"))
    with pytest.raises(InputError, match=r"tiny.zarr: the mask of .*motif.zarr is 6 x 5, expected 110 x 90"):
        pasted(nm.LayerOptions(), grey_store(np.full((5, 6), 255, np.uint8), tmp_path / "tiny.zarr"))
    with pytest.raises(UsageError, match=r"walls.zarr: no layer has walls; give one `edge='wall'`"):
        pasted(nm.LayerOptions(), walls=str(tmp_path / "walls.zarr"))
    with pytest.raises(UsageError, match=r"placed.png: `placed` is written to a Zarr store"):
        pasted(nm.LayerOptions(), placed=str(tmp_path / "placed.png"))
    with pytest.raises(UsageError, match=r"out.zarr: two outputs have the same name"):
        pasted(nm.LayerOptions(), placed=str(tmp_path / "out.zarr"))
    with pytest.raises(OutputError, match=r"plate.zarr: already exists"):
        nm.tiled.paste(maps[0], [maps[1]], maps[0], tiling=HERE)
    with pytest.raises(LimitError, match=r"motif.zarr: has 0.0116 megapixels and must be resampled, .*, up to 0.001"):
        file = nm.LayerFile(maps[1], nm.LayerOptions(rotate=3))
        nm.tiled.paste(maps[0], [file], str(tmp_path / "out.zarr"), reading=nm.ReadOptions(max_megapixels=0.001))
