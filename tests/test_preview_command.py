"""`nmap preview`: every kind of file, messages and errors."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from preview_cases import cone, disc

import nmaptool as nm

ROOT = Path(__file__).parents[1]


@pytest.fixture
def cone_file(tmp_path):
    path = tmp_path / "cone.exr"
    from nmaptool.io.pictures.heights import write_height

    write_height(cone(), path, {}, at="corners")
    return path


def test_the_command_writes_a_picture_and_a_report(run, cone_file, tmp_path):
    out = tmp_path / "view.png"
    done = run(
        "preview", cone_file, "-o", out, "--material", "gold", "--light", "90,30", "--report", tmp_path / "r.json"
    )
    assert done.code == 0, done.err
    np.testing.assert_array_equal(
        cv2.imread(str(out))[..., ::-1], nm.preview(cone(), nm.PreviewOptions(material="gold", light=("90,30",)))
    )
    assert "30 x 20 mm (120 x 80 px), 0 to 5 mm high" in done.err
    assert "gold, lights from 90/30 degrees" in done.err
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert report["options"]["material"] == "gold"
    assert report["files"] == {"files": [str(cone_file)]}
    again = run("preview", cone_file, "-o", out)
    assert again.code == 5
    assert "already exists" in again.err


def test_the_command_reads_every_kind_of_file(run, cone_file, clean_map, tmp_path):
    height = cone()
    np.save(tmp_path / "plain.npy", np.where(disc(80).domain, disc(80).at_pixels(), np.nan))
    nm.write_relief(
        nm.relief(nm.read_normal_map(clean_map)), tmp_path / "a.png", tmp_path / "a.tif", tmp_path / "a.3mf"
    )
    nm.write_mesh(nm.solid(height, nm.SolidOptions(base=nm.length("1mm"))).to_mesh(), tmp_path / "cone.stl")
    files = [cone_file, clean_map, *(tmp_path / name for name in ("plain.npy", "a.png", "a.tif", "a.3mf", "cone.stl"))]
    done = run("preview", *files, "-o", tmp_path / "sheet.png", "--size", "64")
    assert done.code == 0, done.err
    assert cv2.imread(str(tmp_path / "sheet.png")).shape[1] == 3 * (64 + 14) + 14
    assert re.search(r"plain\.npy: 100 x 100 mm \(80 x 80 px\), \S+ to \S+ mm high, 100 mm wide \(assumed\)", done.err)
    assert "a normal map, integrated with the usual options of nmap relief" in done.err
    assert "cone.stl: mesh of 30 x 20 x 6 mm" in done.err
    wide = run("preview", tmp_path / "plain.npy", "-o", tmp_path / "b.png", "--width", "20mm")
    assert "20 mm wide (given)" in wide.err


def test_the_command_solves_a_recipe(run, tmp_path):
    done = run("preview", "samples/scene.toml", "-o", tmp_path / "scene.png", "--size", "128")
    assert done.code == 0, done.err
    assert max(cv2.imread(str(tmp_path / "scene.png")).shape) == 128


@pytest.mark.parametrize(
    ("code", "pattern", "words"),
    [
        (2, "no files given: add one or more, such as coin.npy", ("-o", "a.png")),
        (2, "no output given: add one, such as -o view.png", ("cone.exr",)),
        (2, r"a\.jpg: a preview is written as \.png", ("cone.exr", "-o", "a.jpg")),
        (
            2,
            r"a\.png: ends in \.png; a film is written as \.webp, \.gif, \.mp4",
            ("cone.exr", "-o", "a.png", "--turntable"),
        ),
        (
            2,
            "--turntable: a film shows one relief, and 2 files are given",
            ("cone.exr", "b.exr", "-o", "a.gif", "--turntable"),
        ),
        (
            2,
            "--light 135,-3: an elevation of -3 degrees is not above the plate",
            ("cone.exr", "-o", "a.png", "--light", "135,-3"),
        ),
        (
            2,
            "--section y=99mm: lies at 99 mm; the relief reaches from 0 to 20 mm along y",
            ("cone.exr", "-o", "a.png", "--section", "y=99mm"),
        ),
        (2, "-: a preview is written to a file", ("cone.exr", "-o", "-")),
        (3, r"gone\.exr", ("gone.exr", "-o", "a.png")),
    ],
)
def test_bad_input_is_one_line(refused, cone_file, monkeypatch, code, pattern, words):
    monkeypatch.chdir(cone_file.parent)
    refused(code, pattern, "preview", *words)


def test_negative_azimuths_need_no_equals_sign(run, cone_file, tmp_path):
    done = run("preview", cone_file, "-o", tmp_path / "a.png", "--light", "-45,30", "--light", "80,20,0.4")
    assert done.code == 0, done.err
    assert "lights from -45/30, 80/20 degrees" in done.err


def test_the_preview_of_a_relief_is_the_same_picture(run, clean_map, tmp_path):
    assert (
        run("relief", clean_map, "--preview", tmp_path / "a.png", "-o", tmp_path / "a.exr", "--at", "corners").code == 0
    )
    solved = nm.relief(nm.read_normal_map(clean_map))
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "a.png"))[..., ::-1], nm.preview(solved))


def test_the_command_puts_the_relief_of_a_recipe_on_its_plate(run, tmp_path):
    sample = (ROOT / "samples" / "shell.png").as_posix()
    text = f'[[layer]]\nfile = "{sample}"\n\n[relief]\nheight = "1mm"\nwidth = "20mm"\n\n[plate]\nshape = "round"\n'
    (tmp_path / "coin.toml").write_text(text, encoding="utf-8")
    done = run(
        "preview", tmp_path / "coin.toml", "-o", tmp_path / "coin.png", "--size", "200", "--background", "#ff0000"
    )
    assert done.code == 0, done.err
    picture = cv2.imread(str(tmp_path / "coin.png"))[..., ::-1].astype(int)
    corners = picture[[2, 2, -3, -3], [2, -3, 2, -3]]
    assert (corners[:, 0] > 2 * corners[:, 1]).all()  # the table beside the round plate
    middle = picture[100, 100]
    assert middle[1] > 0.7 * middle[0]
