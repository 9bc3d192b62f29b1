"""Which camera: maps in every order and sign of their axes are read right, or the right order is named."""

from __future__ import annotations

import re

import numpy as np
import pytest

import nmaptool as nm
from bench.order_maps import analytic, from_heights, storages, textures
from bench.orders import DOUBTED, NAMED, OUTCOMES, RIGHT, SAID, SILENT, outcomes
from nmaptool.maps.order_doubts import order_notes
from nmaptool.maps.orders import AS_READ, find_evidence, repeats

MAPS = {true.name: true for true in (*analytic(), *textures())}
WITH_OUTLINE = [true.name for true in analytic()]
EVERYWHERE = np.ones((160, 160), bool)


@pytest.mark.parametrize("name", WITH_OUTLINE)
def test_a_raised_motif_is_read_right_or_its_order_is_named(name):
    found = outcomes(MAPS[name])
    # as it should be and with green down; with red left, which may be a sunken motif with green down
    assert dict(found) == {RIGHT: 2, SAID: 1, NAMED: 45}


@pytest.mark.parametrize("name", ["stones", "waves", "rough"])
def test_a_full_frame_is_never_wrong_in_silence(name):
    found = outcomes(MAPS[name])
    assert (found[SILENT], found[DOUBTED]) == (0, 0)
    assert found[RIGHT] + found[SAID] >= 2  # as it should be, and with green down
    assert sum(found[one] for one in OUTCOMES) == 48


def test_the_48_storages_are_read_right_by_their_swizzles():
    true = MAPS["bust"]
    for stored in storages(true):
        read = nm.decode_normal_map(stored.pixels, nm.ReadOptions(swizzle=stored.swizzle))
        assert np.abs(read.normals - true.normals)[true.motif].max() < 0.02
        assert read.decoding.fits == (stored.swizzle,)
        assert nm.diagnose(read) == ()


@pytest.mark.parametrize("name", MAPS)
def test_the_curl_of_the_other_sign_is_larger(name):
    true = MAPS[name]
    evidence = find_evidence(true.normals, true.motif, EVERYWHERE)
    down = ((0, 1), (1, -1), (2, 1))
    assert evidence.curl_ratio(down, AS_READ) > 1.5
    assert evidence.curl_ratio(AS_READ, down) == pytest.approx(1 / evidence.curl_ratio(down, AS_READ))
    assert evidence.faces_away(AS_READ) == 0
    assert evidence.faces_away(((0, 1), (1, 1), (2, -1))) == 1


def test_the_outline_of_a_hemisphere_points_outwards():
    true = MAPS["sphere"]
    evidence = find_evidence(true.normals, true.motif, EVERYWHERE)
    assert evidence.outline_sign(AS_READ) > 0.9
    assert evidence.outline_sign(((0, -1), (1, -1), (2, 1))) == pytest.approx(-evidence.outline_sign(AS_READ))
    # a quarter turn of the vectors makes them run along the outline
    assert abs(evidence.outline_sign(((1, -1), (0, 1), (2, 1)))) < 0.01
    assert find_evidence(true.normals, EVERYWHERE, EVERYWHERE).outline is None


def test_a_quarter_turn_of_picture_and_vectors_turns_the_evidence():
    true = MAPS["bust"]
    turned = np.rot90(true.normals)[..., [1, 0, 2]] * np.float32((-1, 1, 1))
    one = find_evidence(true.normals, true.motif, EVERYWHERE)
    other = find_evidence(np.ascontiguousarray(turned), np.rot90(true.motif).copy(), EVERYWHERE)
    assert other.outline_sign(AS_READ) == pytest.approx(one.outline_sign(AS_READ), rel=1e-6)
    down = ((0, 1), (1, -1), (2, 1))
    assert other.curl_ratio(down, AS_READ) == pytest.approx(one.curl_ratio(down, AS_READ), rel=1e-4)


@pytest.mark.parametrize(("name", "tileable"), [("letters", True), ("stones", False)])
def test_a_full_frame_with_green_down_names_both_readings(name, tileable):
    """As a warning, unless it is a tileable texture, which was made for an engine."""
    (stored,) = (one for one in storages(MAPS[name]) if one.swizzle == "r,-g,b")
    read = nm.decode_normal_map(stored.pixels)
    said = (order_notes(read.decoding), nm.diagnose(read))
    (doubt,) = said[0] if tileable else said[1]
    assert said[1 if tileable else 0] == ()
    assert "green points down or red points left: both have the same curl, and no outline tells them apart" in doubt
    assert "it is read with green down; if it comes out inside out, use `swizzle='-r,g,b'`" in doubt
    assert (read.decoding.green, read.decoding.green_from) == ("down", "found")
    for confirmed in (nm.ReadOptions(green="down"), nm.ReadOptions(swizzle="r,-g,b"), nm.ReadOptions(from_="directx")):
        read = nm.decode_normal_map(stored.pixels, confirmed)
        assert (nm.diagnose(read), order_notes(read.decoding)) == ((), ())


@pytest.mark.parametrize(("period", "tileable"), [(160 / 5, True), (160 / 4.3, False)])
def test_a_texture_is_tileable_if_its_edges_continue_each_other(period, tileable):
    y, x = np.mgrid[0:160, 0:160] * (2 * np.pi / period)
    slopes = np.dstack([-np.cos(x) * np.cos(y), -np.sin(x) * np.sin(y), np.ones_like(x)])
    waves = (slopes / np.linalg.norm(slopes, axis=2, keepdims=True)).astype(np.float32)
    assert repeats(waves) == tileable
    assert repeats(np.ascontiguousarray(waves.swapaxes(0, 1))) == tileable


def test_a_full_frame_says_that_raised_is_assumed():
    (stored,) = (one for one in storages(MAPS["stones"]) if one.swizzle == "r,g,b")
    read = nm.decode_normal_map(stored.pixels)
    assert nm.diagnose(read) == ()
    assert order_notes(read.decoding) == (
        "raised is assumed: no outline tells; if it comes out inside out, use `swizzle='-r,-g,b'`",
    )


def test_red_left_is_found_by_the_outline():
    (stored,) = (one for one in storages(MAPS["bust"]) if one.swizzle == "-r,g,b")
    decoding = nm.decode_normal_map(stored.pixels).decoding
    assert (decoding.swizzle, decoding.swizzle_from) == ("-r,g,b", "found")
    assert (decoding.green, decoding.green_from) == ("up", "found")
    (note,) = order_notes(decoding)
    assert "red points left, or green points down and the motif is sunken: both have the same curl" in note
    assert (
        "it is read with red left, as estimators write it, so it is raised; if it is sunken, use `green='down'`" in note
    )
    assert decoding.curl_ratio > 1.5  # of the order in use
    engraved = nm.decode_normal_map(stored.pixels, nm.ReadOptions(green="down")).decoding
    assert (engraved.swizzle, engraved.green) == ("r,g,b", "down")


def codes_of(vectors, motif=None):
    codes = np.floor((vectors + 1) / 2 * 255 + 0.5).astype(np.uint8)
    return codes if motif is None else np.dstack([codes, np.where(motif, 255, 0).astype(np.uint8)])


def test_a_motif_on_flat_ground_may_be_sunken_so_it_is_read_with_green_down():
    true = MAPS["bust"]
    sunken = true.normals * np.float32((-1, -1, 1))
    read = nm.decode_normal_map(codes_of(sunken * np.float32((1, -1, 1))))
    assert (read.decoding.background, read.decoding.green, read.decoding.swizzle) == ("flat", "down", "r,g,b")
    assert np.abs(read.normals - sunken).max() < 0.02
    (doubt,) = nm.diagnose(read)
    assert doubt.startswith("looks inverted: ")
    assert "for a raised motif read it with `swizzle='-r,g,b'`" in doubt


def test_every_command_says_that_red_left_is_an_assumption(run, tmp_path, png):
    (stored,) = (one for one in storages(MAPS["bust"]) if one.swizzle == "-r,g,b")
    path, flat = png(tmp_path / "bust.png", stored.pixels), png(tmp_path / "flat.png", codes_of(MAPS["waves"].normals))
    note = "  red points left, or green points down and the motif is sunken"
    for words, out in (("relief", "a.exr"), ("compose split", "layers"), ("compose convert", "b.exr")):
        done = run(*words.split(), path, "-o", tmp_path / out)
        assert (done.code, done.err.count(note)) == (0, 1), done.err
        assert "if it is sunken, use --green down" in done.err
        assert "warning" not in done.err.replace("the map has no background", "")
    for words in ("relief", "compose convert"):  # what is raised matters only for heights
        done = run(*words.split(), flat, "-o", tmp_path / "waves.exr", "--overwrite")
        assert ("raised is assumed" in done.err) == (words == "relief")


def test_every_map_of_a_command_is_doubted(run, tmp_path, png):
    good, bad = (
        next(one for one in storages(MAPS[name]) if one.swizzle == order)
        for name, order in (("bust", "r,g,b"), ("mound", "g,r,b"))
    )
    paths = png(tmp_path / "good.png", good.pixels), png(tmp_path / "bad.png", bad.pixels)
    done = run("compose", "paste", *paths, "-o", tmp_path / "both.exr")
    assert "bad.png: its channels look rotated or mirrored" in done.err
    done = run("compose", "pack", *paths, "-o", tmp_path / "both.psd")
    assert "bad.png: its channels look rotated or mirrored" in done.err


@pytest.mark.parametrize("at", [(0, 0), (700, 220), (1455, 1455)])
def test_a_small_motif_in_a_large_picture_is_measured(at):
    down, across = np.mgrid[-1:1:45j, -1:1:45j]
    r = np.hypot(down, across)
    bumps = np.sin(9 * across + 4 * down) * np.cos(11 * down - 2 * across)
    small = from_heights("mound", 6 * np.cos(np.pi * r.clip(0, 1)) + bumps, r < 0.9)
    pixels = np.zeros((1500, 1500, 4), np.uint8)
    pixels[at[0] : at[0] + 45, at[1] : at[1] + 45] = codes_of(small.normals * np.float32((1, -1, 1)), small.motif)
    read = nm.decode_normal_map(pixels)
    assert (read.decoding.green, read.decoding.green_from) == ("down", "found")
    assert read.decoding.fits == ("r,-g,b",)


def test_a_picture_without_a_motif_has_no_order(run, tmp_path, png):
    flat = np.full((64, 64, 3), (128, 128, 255), np.uint8)
    seen = run("inspect", png(tmp_path / "flat.png", flat))
    assert "every pixel is background" in seen.out
    assert "order" not in seen.out


def test_a_spherical_hollow_is_told_by_its_outline_not_by_its_curl():
    down, across = np.mgrid[-80:80, -80:80]
    r2 = (down**2 + across**2).astype(float)
    bowl = from_heights("bowl", r2 / 200, r2 < 70**2)
    (doubt,) = nm.diagnose(nm.decode_normal_map(codes_of(bowl.normals * np.float32((1, -1, 1)), bowl.motif)))
    assert doubt.startswith(
        "its channels look mirrored: another sign fits the outline; read it with `swizzle='-r,g,b'`"
    )


def test_diagonal_waves_fit_both_orders():
    """x equals y, so their order cannot be told; differences below rounding do not count."""
    down, across = np.mgrid[0:160, 0:160]
    waves = from_heights("waves", 3 * np.sin((across - down) / 6))
    read = nm.decode_normal_map(codes_of(waves.normals * np.float32((1, -1, 1))))
    assert (read.decoding.green, read.decoding.green_from) == ("down", "found")
    assert {"r,-g,b", "-r,g,b", "g,-r,b", "-g,r,b"} == set(read.decoding.fits)
    assert nm.diagnose(read) == ()


def test_a_surface_without_curl_does_not_tell():
    across = np.broadcast_to(np.arange(160.0), (160, 160))
    ridges = from_heights("ridges", 4 * np.sin(across / 9))
    (stored,) = (one for one in storages(ridges) if one.swizzle == "r,g,b")
    read = nm.decode_normal_map(stored.pixels)
    assert (read.decoding.green, read.decoding.green_from, read.decoding.curl_ratio) == ("up", "assumed", None)
    assert order_notes(read.decoding) == (
        "green up is assumed: too little curl to tell; if its forms look twisted, use `green='down'`",
    )


def test_more_than_a_tenth_facing_away_is_a_warning_and_more_than_half_is_refused(run, tmp_path, png):
    true = MAPS["sphere"]
    for share, code in ((0.05, 0), (0.3, 0), (0.7, 3)):
        vectors = true.normals.copy()
        vectors[np.random.default_rng(3).random((160, 160)) < share] *= (1, 1, -1)
        codes = np.floor((vectors + 1) / 2 * 255 + 0.5).astype(np.uint8)
        path = png(tmp_path / f"{share}.png", np.dstack([codes, np.where(true.motif, 255, 0).astype(np.uint8)]))
        for words in (("relief", path), ("compose", "convert", path), ("compose", "transform", path, "--flip-h")):
            done = run(*words, "-o", tmp_path / "out.exr", "--overwrite")
            assert done.code == code, done.err
            assert ("of the motif faces away from the viewer (nz <= 0)" in done.err) == (share > 0.1)
            assert ("or go on with --force" in done.err) == (share > 0.5)
            if share > 0.5:
                assert run(*words, "-o", tmp_path / "out.exr", "--overwrite", "--force").code == 0


@pytest.mark.parametrize(("order", "flag"), [("b,g,r", "b,g,r"), ("r,-g,-b", "r,-g,-b"), ("r,b,-g", "r,b,-g")])
def test_inspect_and_relief_name_the_flag_of_another_camera(run, tmp_path, png, order, flag):
    (stored,) = (one for one in storages(MAPS["bust"]) if one.swizzle == order)
    path = png(tmp_path / "map.png", stored.pixels)
    seen = run("inspect", path)
    assert seen.code == 1
    assert f"--swizzle {flag}" in seen.out
    done = run("relief", path, "-o", tmp_path / "map.exr")
    assert f"--swizzle {flag}" in done.err
    # the flag restores the map
    assert run("relief", path, "-o", tmp_path / "map.exr", "--overwrite", f"--swizzle={flag}").code == 0
    assert run("inspect", path, f"--swizzle={flag}").code == 0


def test_a_map_that_no_order_explains_is_called_object_space():
    rng = np.random.default_rng(5)
    vectors = rng.normal(size=(96, 96, 3)) - (0, 0, 0.3)
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    pixels = np.floor((vectors + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    with pytest.raises(
        nm.InputError, match=r"no order of its channels faces the viewer, as in an object-space"
    ) as told:
        nm.decode_normal_map(pixels)
    assert re.search(r"\d\d% of the motif faces away from the viewer \(nz <= 0\); no order", str(told.value))
