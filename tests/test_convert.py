"""``nmap compose convert``: sound codes are kept; the rest are repaired and counted."""

import io
import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.vectors import unit

OWN_KINDS = [(".png", "16"), (".tif", "16"), (".tif", "float"), (".exr", "float"), (".exr", "half")]


def facing(seed, shape=(120, 150), lowest=-0.2):
    vectors = np.random.default_rng(seed).normal(size=(*shape, 3))
    vectors[..., 2] = np.abs(vectors[..., 2]) + lowest
    return unit(vectors)


def as_map(normals, coverage=None, pitch_mm=None):
    shape = normals.shape[:2]
    coverage = np.ones(shape, np.float32) if coverage is None else coverage.astype(np.float32)
    return nm.NormalMap(normals, coverage, nm.Frame(*shape, pitch_mm))


def soft_cover(shape):
    cover = np.ones(shape, np.float32)
    cover[:, :20] = np.linspace(0, 1, 20)
    return cover


def stored(path):
    return nm.read_raster(path).pixels


@pytest.mark.parametrize(("ending", "bits"), OWN_KINDS)
@pytest.mark.parametrize("covered", [False, True])
def test_converting_to_the_same_format_changes_nothing(tmp_path, ending, bits, covered):
    normals = facing(1)
    cover = soft_cover(normals.shape[:2]) if covered else None
    source, target = tmp_path / f"a{ending}", tmp_path / f"b{ending}"
    if covered:
        normals = np.where((cover > 0)[..., None], normals, np.float32([0, 0, 1]))
    nm.write_normal_map(as_map(normals, cover), source, nm.WriteOptions(bits=bits))
    result = nm.convert(source, target, writing=nm.WriteOptions(bits=bits))
    assert np.array_equal(stored(target), stored(source))
    assert result.report.off_length == 0
    assert stored(target).shape[2] == (4 if covered else 3)
    assert result.report.curl_before == pytest.approx(result.report.curl_after, rel=1e-4)


@pytest.mark.parametrize("between", [("c.png", "16"), ("c.tif", "16"), ("c.exr", "float")])
@pytest.mark.parametrize("backdrop", [None, "flat"])
def test_8_bit_codes_survive_a_deeper_format(tmp_path, dome, codes, png, between, backdrop):
    d = dome()
    name, bits = between
    vectors = facing(2, (400, 500)) if backdrop is None else np.where(d.inside[..., None], d.normals, (0, 0, 1))
    source = png(tmp_path / "a.png", codes(vectors, 8))
    first = nm.convert(source, tmp_path / name, nm.ReadOptions(green="up"), nm.WriteOptions(bits=bits))
    assert first.report.source["zero_code"] == "127.5"  # the vector lengths reveal it, whatever the flat code
    again = nm.convert(tmp_path / name, tmp_path / "b.png", writing=nm.WriteOptions(bits="8"))
    length = np.linalg.norm(first.normal_map.normals, axis=-1)
    assert np.abs(length - 1).max() < 3e-5
    assert (first.report.off_length, again.report.off_length) == (0, 0)
    assert np.array_equal(stored(tmp_path / "b.png"), stored(source))


def test_8_bit_codes_around_128_keep_their_zero_code(tmp_path, dome, png):
    d = dome()
    vectors = np.where(d.inside[..., None], d.normals, (0, 0, 1))
    source = png(tmp_path / "a.png", np.floor(vectors * 127 + 128.5).astype(np.uint8))
    first = nm.convert(source, tmp_path / "b.png")
    assert (first.report.source["zero_code"], first.report.target["zero_code"]) == ("128", "128")
    assert first.report.off_length == 0
    nm.convert(tmp_path / "b.png", tmp_path / "c.png", writing=nm.WriteOptions(bits="8"))
    assert np.array_equal(stored(tmp_path / "c.png"), stored(source))


def test_16_bit_codes_survive_floats(tmp_path, codes, png):
    source = png(tmp_path / "a.png", codes(facing(3, (400, 500)), 16))
    nm.convert(source, tmp_path / "b.exr", nm.ReadOptions(green="up"))
    nm.convert(tmp_path / "b.exr", tmp_path / "c.png")
    assert np.array_equal(stored(tmp_path / "c.png"), stored(source))


@pytest.mark.parametrize("bits", ["8", "16"])
@pytest.mark.parametrize("zero", ["127.5", "128"])
def test_flipping_green_twice_restores_the_codes(tmp_path, bits, zero):
    source, down, back = (tmp_path / f"{name}.png" for name in ("up", "down", "back"))
    nm.write_normal_map(as_map(facing(4)), source, nm.WriteOptions(bits=bits, write_zero_code=zero))
    nm.convert(source, down, writing=nm.WriteOptions(bits=bits, write_green="down"))
    turned = nm.convert(down, back, writing=nm.WriteOptions(bits=bits))
    assert turned.report.source["green"] == "down"
    # of the two codes next to zero, one encodes flat; pixels with the other become flat
    other = (stored(back) != stored(source)).any(axis=-1)
    assert (zero, bits) == ("127.5", "8") or not other.any()
    assert (stored(source)[other] == (128, 127, 255)).all()
    first, second = nm.read_normal_map(source).normals, nm.read_normal_map(down).normals
    assert np.abs(first - second)[~other].max() < 1e-3
    up, low = stored(source).astype(int), stored(down).astype(int)
    assert np.array_equal(up[..., [0, 2]], low[..., [0, 2]])
    codes_of_zero = (2 ** int(bits) - 1) if zero == "127.5" else 2 ** int(bits)
    assert ((up + low)[..., 1] == codes_of_zero)[~other].all()


def test_the_file_determines_the_zero_code_unless_it_is_given(tmp_path):
    flat = np.zeros((20, 30, 3), np.float32) + np.float32([0, 0, 1])
    nm.write_normal_map(as_map(flat), tmp_path / "a.png", nm.WriteOptions(bits="8", write_zero_code="128"))
    for given, expected in (("auto", "128"), ("127", "127"), ("127.5", "127.5")):
        nm.convert(tmp_path / "a.png", tmp_path / "b.png", None, nm.WriteOptions("16", "up", given), overwrite=True)
        assert nm.read_normal_map(tmp_path / "b.png").decoding.zero_code == expected
        assert np.array_equal(nm.read_normal_map(tmp_path / "b.png").normals, flat)


@pytest.mark.parametrize("backdrop", ["white", "grey", "black"])
def test_a_background_becomes_alpha(run, tmp_path, dome, codes, png, backdrop):
    d = dome(128, 128, smooth=True)
    source = png(tmp_path / "a.png", codes(d.normals, 8, backdrop, d.cover))
    done = run("compose", "convert", source, tmp_path / "b.png", "--bits", 8)
    assert (done.code, done.out) == (0, "")
    assert f"background {backdrop}: coverage is stored in alpha" in done.err
    assert "anti-aliased pixels took their normals from inside the motif" in done.err
    back = nm.read_normal_map(tmp_path / "b.png")
    assert back.decoding.background == "alpha"
    assert np.abs(back.coverage - d.cover).mean() < 0.01
    alpha = stored(tmp_path / "b.png")[..., 3]
    nothing = stored(tmp_path / "b.png")[alpha == 0]
    assert (nothing[:, :3] == (128, 128, 255)).all()
    inner = d.cover == 1
    inner[:, :] &= ~np.asarray(stored(source) == 0).all(axis=-1)
    same = (stored(tmp_path / "b.png")[..., :3] == stored(source)).all(axis=-1)
    assert same[inner].mean() > 0.97  # the inner side of the rim may be blended, too


def test_vectors_off_unit_length_are_normalised_once(tmp_path, run, codes, png):
    vectors = facing(5).astype(float)
    vectors[::3] *= 0.7
    source = png(tmp_path / "a.png", codes(vectors, 16))
    first = nm.convert(source, tmp_path / "b.png", nm.ReadOptions(green="up"))
    assert first.report.off_length == vectors[::3].shape[0] * vectors.shape[1]
    assert first.report.vectors == vectors.shape[0] * vectors.shape[1]
    assert first.report.off_length_largest == pytest.approx(0.3, abs=1e-4)
    length = np.linalg.norm(stored(tmp_path / "b.png") / 32767.5 - 1, axis=-1)
    assert np.abs(length - 1).max() < 1e-4
    rest = np.arange(len(vectors)) % 3 > 0
    assert np.array_equal(stored(tmp_path / "b.png")[rest], stored(source)[rest])
    again = nm.convert(tmp_path / "b.png", tmp_path / "c.png")
    assert again.report.off_length == 0
    assert np.array_equal(stored(tmp_path / "c.png"), stored(tmp_path / "b.png"))
    stated = run("compose", "convert", source, tmp_path / "d.png", "--green", "up").err
    assert "6000 of 18000 vectors were off unit length, by up to 0.3: normalised" in stated


@pytest.mark.parametrize("components", ["xy", "octahedral"])
def test_two_components_become_three(run, tmp_path, dome, picture, components):
    d = dome()
    pair = d.normals[..., :2]
    if components == "octahedral":  # every normal faces the viewer
        pair = pair / np.abs(d.normals).sum(axis=-1, keepdims=True)
    source = picture(tmp_path / "a.exr", np.dstack([pair, d.inside]), ("R", "G", "A"))
    done = run("compose", "convert", source, tmp_path / "b.exr", "--components", components)
    assert done.code == 0
    words = {"xy": "x and y, z computed from them", "octahedral": "octahedral codes"}[components]
    assert f"{words}: all three components are written" in done.err
    assert np.abs(stored(tmp_path / "b.exr")[..., :3] - d.normals)[d.inside].max() < 1e-6
    assert run("inspect", tmp_path / "b.exr").code == 0


def test_noise_in_a_flat_background_is_counted(tmp_path, dome, codes, png):
    d = dome(128, 128)
    pixels = codes(np.where(d.inside[..., None], d.normals, (0, 0, 1)))
    noise = np.random.default_rng(6).integers(-1, 2, (128, 128, 2)) * ~d.inside[..., None]
    pixels[..., :2] = pixels[..., :2] + noise
    done = nm.convert(png(tmp_path / "a.png", pixels), tmp_path / "b.png")
    assert done.report.source["background"] == "flat"
    assert done.report.flattened > 0.5 * (~d.inside).sum()
    assert np.array_equal(np.unique(done.normal_map.normals[~done.normal_map.foreground], axis=0), [[0, 0, 1]])


@pytest.mark.parametrize("ending", [".png", ".tif", ".exr"])
def test_metadata_are_kept_and_the_conversion_is_recorded(tmp_path, ending):
    recipe = {"command": "blend", "options": {"mode": "rnm"}}
    own = {"recipe": json.dumps(recipe), "layer": "detail", "view": "front"}
    nm.write_normal_map(as_map(facing(7), pitch_mm=0.125), tmp_path / "a.exr", attributes=own)
    nm.convert(tmp_path / "a.exr", tmp_path / f"b{ending}", writing=nm.WriteOptions(write_green="down"))
    stated = nm.read_raster(tmp_path / f"b{ending}").attributes
    assert (stated["layer"], stated["view"], stated["green"], stated["pitch_mm"]) == (
        "detail",
        "front",
        "down",
        "0.125",
    )
    told = json.loads(stated["recipe"])
    assert (told["command"], told["before"]) == ("convert", recipe)
    assert told["options"]["write_green"] == "down"


def test_a_layer_name_and_a_recipe_that_is_not_json_are_kept(tmp_path, picture):
    names = ("detail.X", "detail.Y", "detail.Z", "base.X", "base.Y", "base.Z")
    both = np.dstack([facing(8), facing(9)])
    source = picture(tmp_path / "a.exr", both, names, nmaptool__recipe="by hand")
    source = f"{source}:detail"
    nm.convert(source, tmp_path / "b.png", nm.ReadOptions(green="up"))
    stated = nm.read_raster(tmp_path / "b.png").attributes
    assert (stated["layer"], json.loads(stated["recipe"])["before"]) == ("detail", "by hand")


@pytest.mark.parametrize("recipe", ["[" * 200_000, "{", ""])
def test_a_recipe_that_cannot_be_read_is_kept_as_text(tmp_path, recipe):
    nm.write_normal_map(as_map(facing(10)), tmp_path / "a.png", attributes={"recipe": recipe})
    nm.convert(tmp_path / "a.png", tmp_path / "b.png")
    assert json.loads(nm.read_raster(tmp_path / "b.png").attributes["recipe"])["before"] == recipe


def test_normals_under_alpha_0_become_flat_and_the_rest_is_kept(tmp_path, codes, png):
    normals = facing(11)
    alpha = np.full(normals.shape[:2], 65535, np.uint16)
    alpha[:, :40] = 0
    pixels = np.dstack([codes(normals, 16), alpha])
    nm.convert(png(tmp_path / "a.png", pixels), tmp_path / "b.png", nm.ReadOptions(green="up"))
    back = stored(tmp_path / "b.png")
    assert np.array_equal(back[:, 40:], pixels[:, 40:])
    assert (back[:, :40] == (32768, 32768, 65535, 0)).all()


def test_the_command_reports_the_conversion(run, tmp_path, clean_map):
    words = ("compose", "convert", clean_map, "-o", tmp_path / "b.exr", "--bits", "half", "--write-green", "down")
    done = run(*words, "--curl", tmp_path / "curl.png", "--report", tmp_path / "r.json")
    assert (done.code, done.out) == (0, "")
    assert "was: 16 bit, zero at 127.5, green up; now: half, green down" in done.err
    assert "all vectors have unit length within rounding" in done.err
    assert "mean |curl|" in done.err
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert report["source"]["bits"] == "16"
    assert report["target"] == {"bits": "half", "green": "down", "zero_code": "0", "alpha": True}
    assert report["curl_before"] == pytest.approx(report["curl_after"], abs=0.005)
    assert report["outputs"] == [str(tmp_path / name) for name in ("b.exr", "curl.png", "r.json")]
    assert nm.read_raster(tmp_path / "curl.png").attributes["kind"] == "curl"
    assert stored(tmp_path / "b.exr").dtype == np.float32
    again = run(*words, "--overwrite", "--quiet", "--json")
    assert (again.code, again.err, json.loads(again.out)["command"]) == (0, "", "convert")


def test_convert_reads_standard_input(run, tmp_path, clean_map, monkeypatch):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(clean_map.read_bytes())))
    done = run("compose", "convert", "-", tmp_path / "b.png")
    assert (done.code, done.err.startswith("standard input: 96 x 96")) == (0, True)
    assert np.array_equal(stored(tmp_path / "b.png")[24:72, 24:72], stored(clean_map)[24:72, 24:72])


def test_wrong_arguments_are_refused(refused, maps, tmp_path):
    clean, out = maps["clean"], tmp_path / "out.png"
    cases = (
        (2, r"no output given: add one", clean),
        (2, r"out.png: -o .*b.png also names the output; give only one of them", clean, out, "-o", tmp_path / "b.png"),
        (2, r"out.gif: ends in .gif; normal maps are written as", clean, tmp_path / "out.gif"),
        (2, r"out.png: --bits half is not supported for .png; use 16 or 8", clean, out, "--bits", "half"),
        (2, r"clean.png: is also an input", clean, clean, "--overwrite"),
        (
            2,
            r'Invalid value "x" for --write-zero-code. Choose from: "auto", "127", "127.5", "128"',
            clean,
            out,
            "--write-zero-code",
            "x",
        ),
        (3, r"missing.png: ", maps["missing"], out),
        (3, r"one.png: has 1 channel", maps["one"], out),
        (3, r"nan.exr: found 1 pixel with NaN", maps["nan"], out),
        (5, r"small.png: already exists; give another name, or --overwrite", clean, maps["small"]),
        (5, r"the folder .* does not exist", clean, tmp_path / "no" / "out.png"),
    )
    for code, pattern, *words in cases:
        refused(code, pattern, "compose", "convert", *words)


def test_the_function_refuses_what_the_command_refuses(maps, tmp_path):
    with pytest.raises(nm.UsageError, match=r"clean.png: is also an output; give another name for the output"):
        nm.convert(maps["clean"], maps["clean"], overwrite=True)
    with pytest.raises(nm.OutputError, match=r"small.png: already exists"):
        nm.convert(maps["clean"], maps["small"])
    with pytest.raises(nm.UsageError, match=r"b.exr: `bits='8'` is not supported for .exr; use float or half"):
        nm.convert(maps["clean"], tmp_path / "b.exr", writing=nm.WriteOptions(bits="8"))
    with pytest.raises(nm.InputError, match=r"one.png: has 1 channel"):
        nm.convert(maps["one"], tmp_path / "b.png")
    assert not (tmp_path / "b.exr").exists()
