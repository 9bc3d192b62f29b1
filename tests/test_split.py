"""Base and detail of maps without a mesh: the function and its command."""

import json

import numpy as np
import pytest
from mesh_cases import angles

import nmaptool as nm
from nmaptool.core.vectors import mean_abs_curl, unit


@pytest.fixture
def bumpy():
    """A dome with fine waves on a disc: the map, the dome alone, and the mask of the disc."""
    y, x = (np.mgrid[0:128, 0:128] + 0.5 - 64) / 64 * [[[1]], [[1]]]
    y = -y
    inside = np.hypot(x, y) < 0.8
    p, q = -0.9 * x, -0.9 * y
    wave = 0.35 * np.cos(2 * np.pi * x * 64 / 6)
    normals = {
        name: unit(np.stack([-(p + more), -q, np.ones_like(x)], axis=-1)) for name, more in (("all", wave), ("dome", 0))
    }
    normals["all"][~inside] = (0, 0, 1)
    whole = nm.NormalMap(normals["all"], inside.astype(np.float32), nm.Frame(128, 128, 0.5), name="dome.exr")
    return whole, normals["dome"], inside


def test_waves_go_into_detail_and_the_dome_into_the_base(bumpy):
    whole, dome, inside = bumpy
    layers = nm.split(whole, nm.SplitOptions(sigma_s=nm.length("4px")))
    middle = inside & (np.hypot(*(np.mgrid[0:128, 0:128] + 0.5 - 64)) < 40)
    assert angles(whole.normals, dome)[middle].mean() > 10
    assert angles(layers.base.normals, dome)[middle].mean() < 0.7
    assert layers.original is whole
    assert layers.report.detail_share > 0.5
    assert layers.report.sigma_s_px == 4
    t = layers.base.normals + np.array([0.0, 0, 1])
    u = layers.detail.normals * [-1.0, -1, 1]
    back = unit(t * (t * u).sum(axis=-1, keepdims=True) / t[..., 2:] - u)
    assert angles(back, whole.normals)[inside].max() < 0.01
    for layer in (layers.base, layers.detail):
        assert np.array_equal(layer.coverage, whole.coverage)
        assert np.array_equal(layer.normals[~inside], np.broadcast_to([0, 0, 1], ((~inside).sum(), 3)))


def test_a_flat_background_that_is_part_of_the_map_does_not_bleed_in(bumpy):
    whole, _, inside = bumpy
    on_flat = nm.NormalMap(whole.normals, np.ones((128, 128), np.float32), whole.frame, foreground=inside)
    one, other = nm.split(whole), nm.split(on_flat)
    assert np.array_equal(one.base.normals, other.base.normals)
    assert np.array_equal(one.detail.normals, other.detail.normals)
    assert one.report.mixture.theta == other.report.mixture.theta


def test_grnf_keeps_normals_that_changed_little(bumpy):
    whole, _, inside = bumpy
    layers = nm.split(whole, nm.SplitOptions(filter="grnf"))
    theta = layers.report.mixture.theta
    residual = np.linalg.norm(whole.normals - nm.split(whole).base.normals, axis=-1)
    kept = (layers.base.normals == whole.normals).all(axis=-1)
    assert kept[residual < 0.99 * theta].all()
    assert not kept[inside & (residual > 1.01 * theta)].any()
    assert np.array_equal(layers.detail.normals[kept & inside][:, 2], np.ones((kept & inside).sum()))


def test_sizes_may_be_in_px_mm_or_percent(bumpy):
    whole = bumpy[0]
    by_px, by_mm, by_share = (
        nm.split(whole, nm.SplitOptions(sigma_s=nm.length(text))).report.sigma_s_px
        for text in ("3.2px", "1.6mm", "2.5%")
    )
    assert by_px == pytest.approx(by_mm) == pytest.approx(by_share)
    unknown = nm.NormalMap(whole.normals, whole.coverage, nm.Frame(128, 128), name="dome.png")
    with pytest.raises(
        nm.UsageError, match=r"`sigma_s='2mm'`: the size of a pixel in dome.png is not known; give px or %"
    ):
        nm.split(unknown, nm.SplitOptions(sigma_s=nm.length("2mm")))
    with pytest.raises(nm.UsageError, match=r"`sigma_s='0.1px'`: is only 0.1 px here; use at least 0.3px"):
        nm.split(whole, nm.SplitOptions(sigma_s=nm.length("0.1px")))


def test_invalid_options_are_refused():
    for changes, message in (
        ({"filter": "blur"}, "`filter='blur'`: use one of rnf, grnf"),
        ({"sigma_r": 0.0}, "`sigma_r=0`: must lie between 0.01 and 10"),
        ({"iterations": 0}, "`iterations=0`: must lie between 1 and 100"),
        ({"detail_encoding": "height"}, "`detail_encoding='height'`: use one of rotation, slope, difference"),
    ):
        with pytest.raises(nm.UsageError, match=message):
            nm.SplitOptions(**changes)


def test_a_map_that_covers_nothing_is_refused():
    flat = np.zeros((4, 4, 3), np.float32) + np.float32([0, 0, 1])
    empty = nm.NormalMap(flat, np.zeros((4, 4), np.float32), nm.Frame(4, 4), name="empty.exr")
    with pytest.raises(nm.InputError, match=r"empty.exr: no pixel is covered, so there is nothing to split"):
        nm.split(empty)


def test_a_map_without_detail_is_not_changed():
    flat = np.zeros((40, 50, 3), np.float32) + np.float32([0, 0, 1])
    layers = nm.split(nm.NormalMap(flat, np.ones((40, 50), np.float32), nm.Frame(40, 50)))
    assert np.array_equal(layers.detail.normals, flat)
    assert layers.report.mixture.form == "none"


def test_the_command_writes_layers_that_relief_reads(run, bumpy, tmp_path):
    source = tmp_path / "dome.exr"
    nm.write_normal_map(bumpy[0], source)
    out = tmp_path / "layers"
    done = run("compose", "split", source, "-o", out, "--sigma-s", "4px", "--plot", tmp_path / "p.png", "--json")
    assert done.code == 0, done.err
    metadata = json.loads(done.out)
    assert metadata["layers"][0]["sigma_s_px"] == 4
    assert {p.name for p in out.iterdir()} == {"original.exr", "base.exr", "detail.exr", "coverage.exr", "sheet.png"}
    original, base = (nm.read_normal_map(out / f"{name}.exr") for name in ("original", "base"))
    assert np.array_equal(original.normals, bumpy[0].normals)
    assert base.frame.pitch_mm == 0.5
    assert base.decoding.green_from == "file"
    made = run("relief", out / "original.exr", "--detail", out / "detail.exr", "-o", tmp_path / "dome.stl")
    assert made.code == 0, made.err
    assert "pitch 0.5 mm (file)" in made.err


def test_one_file_holds_all_layers(run, bumpy, tmp_path):
    source, out = tmp_path / "dome.exr", tmp_path / "layers.exr"
    nm.write_normal_map(bumpy[0], source)
    assert run("compose", "split", source, "-o", out, "-q").err == ""
    layers = nm.split(bumpy[0])
    for name in ("original", "base", "detail"):
        part = nm.read_normal_map(f"{out}:{name}")
        assert np.array_equal(part.normals, getattr(layers, name).normals)
        assert np.array_equal(part.coverage, bumpy[0].coverage)


def test_the_command_refuses_wrong_arguments(refused, bumpy, tmp_path):
    source = tmp_path / "dome.exr"
    nm.write_normal_map(bumpy[0], source)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "base.exr").touch()
    out = tmp_path / "out"
    refused(2, "no output given: add one, such as -o maps", "compose", "split", source)
    refused(2, "--sigma-s wide: expected", "compose", "split", source, "-o", out, "--sigma-s", "wide")
    refused(2, "must lie between 0.01 and 10", "compose", "split", source, "-o", out, "--sigma-r", "-1")
    refused(3, "nothing.png: no such file", "compose", "split", tmp_path / "nothing.png", "-o", out)
    refused(5, "base.exr: already exists", "compose", "split", source, "-o", tmp_path / "full")
    refused(2, "layers are written into a folder", "compose", "split", source, "-o", tmp_path / "a.png")
    refused(5, "the folder .* does not exist; create it first", "compose", "split", source, "-o", tmp_path / "a" / "b")


def test_curl_is_reported_and_shown(bumpy, tmp_path, run):
    nm.write_normal_map(bumpy[0], tmp_path / "map.exr")
    done = run("compose", "split", tmp_path / "map.exr", "-o", tmp_path / "maps", "--curl", tmp_path / "curl.png")
    assert done.code == 0
    layers = nm.split(bumpy[0])
    assert set(layers.report.curl) == {"original", "base", "detail"}
    assert layers.report.curl["base"] == pytest.approx(mean_abs_curl(layers.base.normals, layers.coverage > 0))
    assert (
        f"mean |curl| original {layers.report.curl['original']:.4f}, base {layers.report.curl['base']:.4f}" in done.err
    )
    shown = nm.read_raster(tmp_path / "curl.png").pixels
    assert np.abs(shown.astype(int) - nm.curl_picture(layers.base)).max() <= 8
