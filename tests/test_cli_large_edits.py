"""Editing commands on large maps, as a user calls them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tiled_scenes import as_store, bumps, disc, grey_store, pixels, whole

import nmaptool as nm

pytest.importorskip("zarr")
TILES = ("--tile", "64", "--workers", "1")


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    as_store(bumps(90, 140, 1, motif=disc(90, 140, 40)), "base.zarr")
    as_store(bumps(90, 140, 2), "detail.zarr")
    grey_store(np.round(disc(90, 140, 30) * 255).astype(np.uint8), "mask.zarr")
    grey_store((np.hypot(*np.mgrid[:90, :140]) * 300).astype(np.uint16), "depth.zarr")
    return tmp_path


def test_blend(run, place):
    done = run(
        "compose", "blend", "base.zarr", "detail.zarr", "-o", "out.zarr", "--mode", "pd", "--bits", "float", *TILES
    )
    assert done.code == 0, done.err
    expected = nm.blend(whole("base.zarr"), whole("detail.zarr"), nm.BlendOptions(mode="pd"))
    assert np.array_equal(pixels("out.zarr")[..., :3], expected.normal_map.normals)
    assert "6 tiles of 64 px" in done.err
    assert "wrote out.zarr" in done.err


def test_paste_and_its_pictures(run, place):
    done = run(
        *("compose", "paste", "detail.zarr", "base.zarr", "-o", "out.zarr", "--at", "40%,50%", "--feather", "4px"),
        *("--placed", "placed.zarr", "--report", "report.json", *TILES),
    )
    assert done.code == 0, done.err
    assert "layers touch 4 of them, the others are copied" in done.err
    report = json.loads((place / "report.json").read_text())
    assert (report["overlap"], report["report"]["layers"][0]["name"]) == (5, "base.zarr")
    assert pixels("placed.zarr").max() == 255


def test_split_then_the_detail_is_read(run, place):
    done = run("compose", "split", "base.zarr", "-o", "layers.zarr", "--sigma-s", "3px", *TILES)
    assert done.code == 0, done.err
    assert "rnf: sigma_s 3px = 3.0 px" in done.err
    again = run("compose", "blend", "layers.zarr:base", "layers.zarr:detail", "-o", "again.zarr", *TILES)
    assert again.code == 0, again.err
    original, restored = pixels("base.zarr"), whole("again.zarr").normals
    assert np.abs(original[..., :3] - restored)[original[..., 3] == 1].max() < 1e-3


def test_depth(run, place):
    done = run(
        "compose", "depth", "depth.zarr", "-o", "out.zarr", "--mask", "mask.zarr", "--depth-scale", "20%", *TILES
    )
    assert done.code == 0, done.err
    assert "depth.zarr: 140 x 90" in done.err
    assert pixels("out.zarr").shape == (90, 140, 4)


def test_inspect(run, place):
    done = run("inspect", "base.zarr", *TILES)
    assert done.code == 0, done.err
    assert "chunks       64 x 64 px; 6 tiles of 64 px inspected" in done.out
    data = json.loads(run("inspect", "base.zarr", "--json", *TILES).out)
    assert (data["tiles"], data["unreadable"]) == (6, 0)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("blend", "base.zarr", "detail.zarr", "-o", "o.zarr", "--curl", "c.png"), "--curl: is not for large maps"),
        (("blend", "base.zarr", "detail.zarr", "-o", "o.zarr", "--fit"), "--fit: is not for large maps; leave it out"),
        (("blend", "base.zarr", "detail.zarr"), "no output given: add one, such as -o map.zarr"),
        (("blend", "base.zarr", "detail.zarr", "-o", "o.png"), "o.png: a blended map is written to a Zarr store"),
        (
            ("paste", "base.zarr", "detail.zarr", "-o", "o.zarr", "--placed", "p.png"),
            "--placed is written to a Zarr store",
        ),
        (("split", "base.zarr", "-o", "o.zarr", "--plot", "p.png"), "--plot: is not for large maps; leave it out"),
        (("split", "base.zarr", "-o", "o.zarr", "--format", "png"), "--format: is not for large maps; leave it out"),
        (("depth", "depth.zarr", "-o", "o.zarr", "--jumps-out", "j.png"), "--jumps-out: is not for large maps"),
        (("blend", "a.png", "b.png", "-o", "o.png", "--tile", "64"), "--tile: is for large maps: Zarr stores, folders"),
    ],
)
def test_what_does_not_apply_is_refused_in_one_line(run, place, words, told):
    done = run("compose", *words)
    assert done.code != 0
    assert told in done.err
    assert done.err.count("\n") == 1
    assert not list(place.glob("o.*"))
