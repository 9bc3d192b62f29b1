"""Presets: the pictures of every program are read right with its preset, and never wrong in silence without."""

from __future__ import annotations

import json

import numpy as np
import pytest
from writer_cases import WRITERS, dxt5nm, picture_of

import nmaptool as nm
from bench.order_maps import analytic
from nmaptool.options.presets import DEPTH_PRESETS, NORMAL_PRESETS

MOTIFS = {true.name: true for true in analytic() if true.name in ("sphere", "bust")}
# the correlation of x and of y with the truth
LEAST = 0.999


def correlation(found: np.ndarray, true: np.ndarray, inside: np.ndarray) -> float:
    pairs = [np.corrcoef(found[inside][:, axis], true[inside][:, axis])[0, 1] for axis in (0, 1)]
    return float(min(pairs))


@pytest.mark.parametrize("motif", MOTIFS)
@pytest.mark.parametrize("name", WRITERS)
def test_a_preset_reads_what_its_program_writes(name, motif):
    writer, true = WRITERS[name], MOTIFS[motif]
    picture = picture_of(writer, true.normals, true.motif)
    read = nm.decode_normal_map(picture, nm.ReadOptions(from_=writer.preset))
    assert correlation(read.normals, true.normals, true.motif) > LEAST
    assert (read.decoding.preset, read.decoding.preset_from) == (writer.preset, "given")
    # no tilt from a wrong zero code: the wall of a full frame is flat
    if writer.outside == "wall":
        assert np.abs(read.normals[~true.motif][:, :2]).max() < 1e-3
    assert (read.coverage[~true.motif] == 0).all() == (writer.outside != "wall")


@pytest.mark.parametrize("motif", MOTIFS)
@pytest.mark.parametrize("name", WRITERS)
def test_without_a_preset_it_is_right_warned_or_refused(name, motif):
    writer, true = WRITERS[name], MOTIFS[motif]
    picture = picture_of(writer, true.normals, true.motif)
    try:
        read = nm.decode_normal_map(picture)
    except nm.InputError as error:
        assert "faces away from the viewer" in str(error)
        return
    warned = (*nm.diagnose(read), *read.decoding.warnings)
    assert correlation(read.normals, true.normals, true.motif) > LEAST or warned


@pytest.mark.parametrize("motif", MOTIFS)
@pytest.mark.parametrize("given", [{}, {"from_": "dxt5nm"}, {"swizzle": "a,g,b", "components": "xy"}])
def test_x_in_alpha_is_recognised_and_can_be_given(motif, given):
    true = MOTIFS[motif]
    read = nm.decode_normal_map(dxt5nm(true.normals), nm.ReadOptions(**given))
    assert correlation(read.normals, true.normals, true.motif) > LEAST
    assert (read.decoding.swizzle, read.decoding.components) == ("a,g,b", "xy")
    assert read.decoding.preset_from == {0: "found", 1: "given", 2: "assumed"}[len(given)]
    assert (read.coverage == 1).all()


def test_an_inspection_says_that_x_is_in_alpha(run, tmp_path, png):
    path = png(tmp_path / "unity.png", dxt5nm(MOTIFS["bust"].normals))
    seen = run("inspect", path)
    assert (seen.code, "! x is in alpha and y in green (DXT5nm)" in seen.out) == (1, True)
    assert "components   x and y, z computed from them (found)" in seen.out
    assert "as dxt5nm writes it (found)" in run("relief", path, "-o", tmp_path / "unity.exr").err
    assert "(preset)" in run("inspect", path, "--from", "dxt5nm").out


CURVES = {
    "srgb": lambda v: np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1 / 2.4) - 0.055),
    "linear": lambda v: np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4),
    "video": lambda v: (16 + 219 * v) / 255,
}


@pytest.mark.parametrize("kind", ["8", "16", "float"])
@pytest.mark.parametrize("curve", CURVES)
def test_a_curve_is_named_and_undone(curve, kind):
    true = MOTIFS["bust"]
    stored = CURVES[curve]((true.normals.astype(np.float64) + 1) / 2)
    if kind == "float":
        picture = stored.astype(np.float32)
    else:
        top = 255 if kind == "8" else 65535
        picture = np.floor(stored * top + 0.5).astype(np.uint8 if kind == "8" else np.uint16)
    read = nm.decode_normal_map(picture)
    assert any(f"read it with `curve={curve!r}`, or export it again as raw" in text for text in read.decoding.warnings)
    straight = nm.decode_normal_map(picture, nm.ReadOptions(curve=curve))
    assert correlation(straight.normals, true.normals, true.motif) > LEAST
    assert (straight.decoding.curve, straight.decoding.warnings) == (curve, ())
    error = np.abs(straight.normals - true.normals)[true.motif]
    # a linearised picture has few dark codes in 8 bits
    assert error.mean() < (0.01 if kind == "8" else 2e-5)


def test_a_grey_picture_is_told_to_be_heights():
    grey = np.dstack([np.linspace(20, 230, 64).astype(np.uint8) + np.zeros((64, 1), np.uint8)] * 3)
    (warning,) = nm.decode_normal_map(grey, nm.ReadOptions(force=True, background_color="none")).decoding.warnings[:1]
    assert warning == "is a grey picture: heights or depths, not normals; turn it into normals: nmap compose depth"


def test_the_presets_of_all_programs_are_tested():
    tested = {writer.preset for writer in WRITERS.values()} | {"dxt5nm"}
    # these name an order, not a program; they are the orders of programs above
    assert set(NORMAL_PRESETS) - tested == {"opengl", "directx", "world", "opencv"}
    for alias, like in {"opengl": "unity", "directx": "unreal", "world": "blender", "opencv": "moge-array"}.items():
        own, other = NORMAL_PRESETS[alias], NORMAL_PRESETS[like]
        assert (own.swizzle, own.green) == (other.swizzle, other.green)


def test_options_that_are_given_override_a_preset():
    given = nm.ReadOptions(from_="omnidata", zero_code="128", green="up").as_written_by("omnidata")
    assert (given.swizzle, given.green, given.zero_code) == ("r,g,-b", "up", "128")
    ordered = nm.ReadOptions(from_="omnidata", swizzle="r,g,b").as_written_by("omnidata")
    assert (ordered.swizzle, ordered.green, ordered.zero_code) == ("r,g,b", "auto", "127")


def test_alpha_cannot_be_used_if_there_is_none():
    with pytest.raises(
        nm.UsageError, match=r"picture: `swizzle='a,g,b'` uses alpha, but its channels are R, G, B; take"
    ):
        nm.decode_normal_map(np.zeros((4, 4, 3), np.uint8), nm.ReadOptions(swizzle="a,g,b"))


def test_presets_are_listed(run):
    listed = run("inspect", "--presets")
    assert (listed.code, listed.err) == (0, "")
    for name, preset in {**NORMAL_PRESETS, **DEPTH_PRESETS}.items():
        assert f"  {name} " in listed.out
        assert preset.description in listed.out
    tables = json.loads(run("inspect", "--presets", "--json").out)
    assert list(tables["normals"]) == list(NORMAL_PRESETS)
    assert list(tables["depths"]) == list(DEPTH_PRESETS)


def test_a_preset_is_a_flag_and_a_key(run, tmp_path, png):
    true = MOTIFS["bust"]
    path = png(tmp_path / "dsine.png", picture_of(WRITERS["DSINE PNG"], true.normals, true.motif))
    done = run("relief", path, "--from", "dsine", "-o", tmp_path / "bust.exr")
    assert "as dsine writes it (given)" in done.err
    assert "warning" not in done.err.replace("the map has no background", "")
    recipe = nm.parse_recipe({"layer": [{"file": "dsine.png", "read": {"from": "dsine"}}]})
    assert recipe.layers[0].read == {"from_": "dsine"}
    with pytest.raises(nm.UsageError, match=r"`from_='dsin'`: use one of auto, opengl, directx"):
        nm.ReadOptions(from_="dsin")


def test_green_of_a_texture_with_x_in_alpha_is_detected(run, tmp_path, png):
    """Unity writes green up, Unreal and Source write it down."""
    true = MOTIFS["bust"]
    picture = dxt5nm(true.normals * np.float32((1, -1, 1)))
    for given in ({}, {"from_": "dxt5nm"}):
        read = nm.decode_normal_map(picture, nm.ReadOptions(**given))
        assert (read.decoding.green, read.decoding.green_from) == ("down", "found")
        assert correlation(read.normals, true.normals, true.motif) > LEAST
    assert (
        "dxt5nm                Unity, Unreal and Source textures with x in alpha, y in green [a,g,b, green detected]"
        in (run("inspect", "--presets").out)
    )


def test_a_swizzle_with_alpha_needs_no_components_if_red_holds_nothing():
    true = MOTIFS["bust"]
    read = nm.decode_normal_map(dxt5nm(true.normals * np.float32((-1, 1, 1))), nm.ReadOptions(swizzle="-a,g,b"))
    assert (read.decoding.components, read.decoding.swizzle_from) == ("xy", "given")
    assert correlation(read.normals, true.normals, true.motif) > LEAST


def test_a_grey_picture_with_data_in_alpha_may_have_x_there():
    true = MOTIFS["bust"]
    codes = dxt5nm(true.normals)
    grey = codes[..., [1, 1, 1, 3]]
    (told, *_) = (
        text for text in nm.decode_normal_map(grey, nm.ReadOptions(force=True)).decoding.warnings if "grey" in text
    )
    assert told.endswith("turn it into normals: nmap compose depth; or, if x is in alpha, use `from_='dxt5nm'`")
    read = nm.decode_normal_map(grey, nm.ReadOptions(from_="dxt5nm"))
    assert correlation(read.normals, true.normals, true.motif) > LEAST


def test_a_picture_of_another_kind_is_refused_as_such():
    """Most of a dark picture faces away if it is read as a map; the error names no other order."""
    rng = np.random.default_rng(2)
    grey = np.repeat(rng.integers(0, 100, (64, 64, 1), np.uint8), 3, axis=2)
    color = rng.integers(0, 100, (64, 64, 3), np.uint8)
    for picture, message in (
        (grey, "is a grey picture: heights or depths"),
        (color, "does not look like a normal map"),
    ):
        with pytest.raises(nm.InputError, match=rf"picture: {message}.*, or go on with `force`") as told:
            nm.decode_normal_map(picture, nm.ReadOptions(background_color="none"))
        assert "swizzle" not in str(told.value)


@pytest.mark.parametrize("blue", [0, 64])
def test_a_constant_blue_that_faces_away_is_not_z(blue):
    """x and y of a shallow surface are so small that they have unit length whatever its sign."""
    true = MOTIFS["bust"]
    shallow = true.normals * np.float32((0.05, 0.05, 1))
    codes = np.floor((shallow + 1) / 2 * 255 + 0.5).astype(np.uint8)
    codes[..., 2] = blue
    read = nm.decode_normal_map(codes)
    assert (read.decoding.components, read.decoding.components_from) == ("xy", "found")
    assert np.abs(read.normals[..., :2] - shallow[..., :2]).max() < 0.01


def test_a_preset_is_named_in_errors_and_its_z_does_not_matter_for_two_components():
    true = MOTIFS["bust"]
    codes = np.floor((true.normals * np.float32((1, -1, 1)) + 1) / 2 * 255 + 0.5).astype(np.uint8)
    with pytest.raises(
        nm.UsageError, match=r"picture: `from_='dxt5nm'` uses alpha, but its channels are R, G, B; take x"
    ):
        nm.decode_normal_map(codes, nm.ReadOptions(from_="dxt5nm"))
    read = nm.decode_normal_map(codes, nm.ReadOptions(from_="opencv", components="xy"))
    assert (read.decoding.swizzle, read.decoding.green) == ("r,g,b", "down")
    assert correlation(read.normals, true.normals, true.motif) > LEAST
    with pytest.raises(nm.UsageError, match=r"`swizzle='r,g,-b'`: z is computed from x and y and is never negative"):
        nm.decode_normal_map(codes, nm.ReadOptions(swizzle="r,g,-b", components="xy"))


def test_a_curve_has_no_signed_values():
    with pytest.raises(
        nm.UsageError, match=r"`curve='srgb'`: applies to values from 0 to 1; leave out `encoding='signed'`"
    ):
        nm.ReadOptions(curve="srgb", encoding="signed")
    floats = np.full((8, 8, 3), 1e30, np.float32)
    with pytest.raises(nm.InputError, match=r"found 192 pixels? with NaN or infinite values|found 64 pixels with NaN"):
        nm.decode_normal_map(floats, nm.ReadOptions(curve="srgb"))
