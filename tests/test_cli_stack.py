"""``nmap compose stack``: the map of a recipe, and the recipe in its metadata."""

import io
import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from stack_cases import SCENE, write_maps

import nmaptool as nm

NESTED = '[canvas]\nsize = "99x99"\n[[layer]]\nfile = "../leaf.png"\nat = "20%,20%"\n'


@pytest.fixture
def folder(tmp_path, png):
    write_maps(tmp_path, png)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "leaf.toml").write_text(NESTED, encoding="utf-8")
    more = '[[layer]]\nrecipe = "parts/leaf.toml"\n[[layer]]\nname = "idea"\nfile = "gone.exr"\nhidden = true\n'
    (tmp_path / "scene.toml").write_text(SCENE + more, encoding="utf-8")
    return tmp_path


@pytest.fixture
def feed(monkeypatch):
    """``feed(text)`` puts text on standard input."""
    return lambda text: monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(text.encode())))


def pixels(path):
    return nm.read_raster(path).pixels


def test_stack_writes_the_result_of_compose(run, folder):
    out = folder / "scene.exr"
    pictures = ("--curl", folder / "curl.png", "--placed", folder / "placed.png", "--report", folder / "scene.json")
    done = run("compose", "stack", folder / "scene.toml", "-o", out, *pictures)
    assert done.code == 0, done.err
    stack = nm.read_stack(folder / "scene.toml")
    result = nm.compose(stack.layers, stack.canvas)
    assert np.array_equal(pixels(out), result.normal_map.normals)
    assert np.array_equal(pixels(folder / "placed.png")[..., 0], np.floor(result.placed * 65535.0 + 0.5))
    assert pixels(folder / "curl.png").shape == (60, 80, 3)
    metadata = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    assert [layer["name"] for layer in metadata["layers"]] == ["bunny", "ornaments", "parts/leaf.toml"]
    assert len(metadata["layers"][1]["layers"]) == 2
    assert metadata["hidden"] == [f"{folder / 'scene.toml'}, line 40: layer 5 (idea)"]
    assert metadata["outside"] == []
    assert metadata["files"]["recipes"] == ["parts/leaf.toml"]
    assert metadata["options"]["width"] == "40mm"
    warning = f"nmap: warning: {folder / 'parts' / 'leaf.toml'}: its canvas is ignored"
    assert f"layer 5 (idea): hidden, left out\n{warning}" in done.err
    assert "bunny: over, strength 0.8 at" in done.err
    assert f"wrote {out}" in done.err


@pytest.mark.parametrize("ending", ["png", "tif", "exr"])
def test_the_recipe_in_the_metadata_gives_the_same_map(run, folder, ending):
    one, two, three = (folder / f"{name}.{ending}" for name in ("one", "two", "three"))
    assert run("compose", "stack", folder / "scene.toml", "-o", one, "--green", "down", "--width", "5cm").code == 0
    text = nm.read_raster(one).attributes["recipe"]
    assert 'width = "5cm"' in text
    assert 'file = "parts/../leaf.png"' in text
    (folder / "parts" / "leaf.toml").unlink()  # the metadata contain its layers
    assert run("compose", "stack", one, "-o", two).code == 0
    (folder / "again.toml").write_text(text, encoding="utf-8")
    assert run("compose", "stack", folder / "again.toml", "-o", three).code == 0
    for again in (two, three):
        assert np.array_equal(pixels(again), pixels(one))
        assert nm.read_raster(again).attributes == nm.read_raster(one).attributes
    plain = folder / f"plain.{ending}"
    (folder / "parts" / "leaf.toml").write_text(NESTED, encoding="utf-8")
    run("compose", "stack", folder / "scene.toml", "-o", plain)
    assert not np.array_equal(pixels(plain), pixels(one))


def test_metadata_text_is_read_back_whatever_it_contains(folder, tmp_path):
    text = "a = 'x'\r\nnmaptool:green=down\n\\n\\\\n \u2028 ä漢😀 \x85"
    leaf = nm.read_normal_map(folder / "leaf.png")
    for ending in ("png", "tif", "exr"):
        nm.write_normal_map(leaf, tmp_path / f"out.{ending}", attributes={"recipe": text})
        attributes = nm.read_raster(tmp_path / f"out.{ending}").attributes
        assert attributes["recipe"] == text
        assert attributes["green"] == "up"


def test_a_recipe_from_standard_input_refers_to_the_current_folder(run, folder, feed, monkeypatch):
    monkeypatch.chdir(folder)
    run("compose", "stack", "scene.toml", "-o", "file.png")
    feed((folder / "scene.toml").read_text(encoding="utf-8"))
    done = run("compose", "stack", "-", "-o", "stream.png")
    assert done.code == 0, done.err
    assert "standard input, line 40: layer 5 (idea): hidden" in done.err
    assert np.array_equal(pixels("stream.png"), pixels("file.png"))
    monkeypatch.chdir(folder / "parts")
    feed((folder / "scene.toml").read_text(encoding="utf-8"))
    assert run("compose", "stack", "-", "-o", folder / "far.png", "--folder", folder).code == 0
    assert np.array_equal(pixels(folder / "far.png"), pixels(folder / "file.png"))


def test_the_canvas_can_be_set_by_flags(run, folder):
    out = folder / "out.exr"
    done = run("compose", "stack", folder / "scene.toml", "-o", out, "--size", "80x61", "--width", "41mm")
    assert done.code == 3  # a group's mask must have the size of the canvas
    assert "scene.toml, line 20: layer 3 (ornaments): the mask of ornaments is 80 x 60, expected 80 x 61" in done.err
    (folder / "plain.toml").write_text(
        '[canvas]\nsize = "9x9"\nground = "flat"\n[[layer]]\nfile = "bunny.exr"\n', encoding="utf-8"
    )
    assert run("compose", "stack", folder / "plain.toml", "-o", out, "--size", "100x50", "--width", "41mm").code == 0
    assert nm.read_normal_map(out).frame == nm.Frame(50, 100, 0.41)
    assert (
        nm.read_raster(out)
        .attributes["recipe"]
        .startswith('[canvas]\nsize = "100x50"\nwidth = "41mm"\nground = "flat"\n')
    )


def test_files_outside_the_folder_are_reported(run, folder):
    (folder / "parts" / "up.toml").write_text('[[layer]]\nfile = "../plate.exr"\n', encoding="utf-8")
    done = run("compose", "stack", folder / "parts" / "up.toml", "-o", folder / "out.png", "--json")
    assert done.code == 0
    assert "up.toml: reads ../plate.exr, which is outside the recipe's folder" in done.err
    assert json.loads(done.out)["outside"] == ["../plate.exr"]


@pytest.mark.parametrize(
    ("code", "text", "message"),
    [
        (3, '[[layer]]\nfil = "a"', r"scene.toml, line 2: layer 1: unknown key 'fil'; did you mean 'file'\?"),
        (3, '[[layer]]\nfile = "gone.exr"', r"scene.toml, line 1: layer 1 \(gone.exr\): .*gone.exr: no such file"),
        (3, "[[layer]]\nfile = gone", "scene.toml: is not valid TOML at line 2, column 8: found file = gone;"),
        (3, '[[layer]]\nrecipe = "scene.toml"', r"recipes include each other: .*scene.toml -> scene.toml; remove one"),
        (
            3,
            '[[layer]]\nfile = "plate.exr"\n[[layer]]\nname = "b"\nfile = "bunny.exr"\nat = "900px,0"',
            (
                r"scene.toml, line 3: layer 2 \(b\): "
                r"its area from .* is outside the canvas of 80 x 60 px; move it with at$"
            ),
        ),
        (
            2,
            '[[layer]]\nfile = "leaf.png"\n[[layer]]\nname = "b"\nfile = "bunny.exr"\nat = "9mm,0"',
            r'scene.toml, line 3: layer 2 \(b\): 9mm: the size of a pixel is not known; give width = "100mm"',
        ),
        (
            4,
            '[canvas]\nsize = "99999x99999"\n[[layer]]\nfile = "leaf.png"',
            "scene.toml: the canvas of 99999 x 99999 has",
        ),
    ],
)
def test_a_wrong_recipe_is_refused(refused, folder, code, text, message):
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    refused(code, message, "compose", "stack", folder / "scene.toml", "-o", folder / "out.png")


def test_wrong_arguments_are_refused(refused, folder, feed):
    scene, out = folder / "scene.toml", folder / "out.png"
    refused(2, "no output given: add one", "compose", "stack", scene)
    refused(3, "no.toml: no such file", "compose", "stack", folder / "no.toml", "-o", out)
    refused(2, "--size big: expected columns x rows", "compose", "stack", scene, "-o", out, "--size", "big")
    refused(2, "--width 9px: sets the size of a pixel", "compose", "stack", scene, "-o", out, "--width", "9px")
    refused(2, "plate.exr: is also an input", "compose", "stack", scene, "-o", folder / "plate.exr", "--overwrite")
    refused(2, "wide.png: is also an input", "compose", "stack", scene, "-o", folder / "wide.png", "--overwrite")
    refused(5, "leaf.png: already exists", "compose", "stack", scene, "-o", folder / "leaf.png")
    refused(4, "more than the limit of 0.001", "compose", "stack", scene, "-o", out, "--max-megapixels", "0.001")
    for text, message in (("", "standard input: is empty"), ("x", "standard input: is not valid TOML at line 1")):
        feed(text)
        refused(3, message, "compose", "stack", "-", "-o", out)


def test_a_file_given_by_its_layer_is_an_input_too(refused, folder):
    nm.write_layers(nm.split(nm.read_normal_map(folder / "plate.exr")), folder / "maps.exr")
    (folder / "scene.toml").write_text('[[layer]]\nfile = "maps.exr:original"\n', encoding="utf-8")
    out = folder / "maps.exr"
    refused(2, "maps.exr: is also an input", "compose", "stack", folder / "scene.toml", "-o", out, "--overwrite")
