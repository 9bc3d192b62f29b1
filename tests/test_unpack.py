"""Packing and unpacking on the command line: folders, safe names, recipes, exit codes."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from workspace_cases import bumpy, packed

import nmaptool as nm
from nmaptool.io.output.unpacked_recipe import safe_names


@pytest.fixture
def maps(tmp_path):
    nm.write_normal_map(bumpy(), tmp_path / "base.exr")
    nm.write_normal_map(bumpy(60, 50, 1), tmp_path / "detail.png")
    return tmp_path


@pytest.mark.parametrize("ending", ["psd", "psb", "ora", "tif", "exr"])
def test_packed_layers_are_unpacked_unchanged(maps, run, ending):
    work = maps / f"work.{ending}"
    places = ("--at", "0,0", "--at", "-12px,40px")
    done = run("compose", "pack", maps / "base.exr", maps / "detail.png", "-o", work, *places)
    assert done.code == 0, done.err
    assert done.out == ""
    assert "2 layers on 180 x 160" in done.err
    done = run("compose", "unpack", work, "-o", maps / "out")
    assert done.code == 0, done.err
    assert "clean: no findings" in done.out
    assert sorted(p.name for p in (maps / "out").iterdir()) == ["base.exr", "detail.exr", "recipe.toml"]
    back = nm.read_normal_map(maps / "out" / "base.exr")
    assert np.abs(back.normals - bumpy().normals)[bumpy().coverage > 0].max() < 2 / 65535
    assert np.abs(back.coverage - bumpy().coverage).max() < 1 / 65535
    recipe = tomllib.loads((maps / "out" / "recipe.toml").read_text(encoding="utf-8"))
    assert recipe["canvas"] == {"size": "180x160", "width": "18mm"}
    assert [(one["name"], one["file"], one["at"]) for one in recipe["layer"]] == [
        ("base", "base.exr", "0px,0px"),
        ("detail", "detail.exr", "-12px,40px"),
    ]
    assert all(one["anchor"] == "top-left" and one.get("mode", "over") == "over" for one in recipe["layer"])


def test_png_format_masks_names_and_report_are_written(maps, run, png):
    png(maps / "mask.png", np.full((60, 50), 32768, np.uint16))
    flags = ("--name", "Grund", "--name", "Blatt", "--mask", "none", "--mask", maps / "mask.png", "--bits", "8")
    done = run("compose", "pack", maps / "base.exr", maps / "detail.png", "-o", maps / "w.psd", *flags, "--json")
    assert done.code == 0, done.err
    assert [layer["name"] for layer in json.loads(done.out)["layers"]] == ["Grund", "Blatt"]
    report = maps / "r.json"
    done = run("compose", "unpack", maps / "w.psd", "-o", maps / "out", "--format", "png", "--report", report, "-q")
    assert (done.code, done.out, done.err) == (0, "", "")
    assert {p.name for p in (maps / "out").iterdir()} == {"Grund.png", "Blatt.png", "Blatt.mask.png", "recipe.toml"}
    assert nm.read_raster(maps / "out" / "Grund.png").bits == 16
    assert nm.read_grey(maps / "out" / "Blatt.mask.png") == pytest.approx(128 / 255, abs=1e-4)
    metadata = json.loads(report.read_text(encoding="utf-8"))
    assert (metadata["bits"], metadata["findings"], metadata["has_words"]) == (8, [], True)
    assert (
        tomllib.loads((maps / "out" / "recipe.toml").read_text(encoding="utf-8"))["layer"][1]["mask"]
        == "Blatt.mask.png"
    )


def test_findings_are_printed_and_the_exit_code_is_1(tmp_path, run):
    pixels = packed().layers[0].pixels[:, ::-1].copy()
    nm.write_workspace(packed(pixels=pixels), tmp_path / "w.psd")
    done = run("compose", "unpack", tmp_path / "w.psd", "-o", tmp_path / "out")
    assert done.code == 1
    assert "! bumpy: was mirrored left to right, but its vectors were not" in done.out
    assert "    -> change its vectors too: transform the map with --flip-h --vectors-only" in done.out
    assert (tmp_path / "out" / "bumpy.exr").exists()
    done = run("compose", "unpack", tmp_path / "w.psd", "-o", tmp_path / "out", "--overwrite", "--json")
    assert done.code == 1
    assert json.loads(done.out)["findings"][0]["code"] == "turned"


def test_groups_become_nested_layers(tmp_path):
    outer, inner = nm.WorkspaceGroup("outer", opacity=0.5), nm.WorkspaceGroup('in"ner', visible=False)
    workspace = packed(groups=(outer,))
    lower, upper = workspace.layers
    last = replace(upper, name="last", groups=(outer,), visible=False)
    workspace = replace(workspace, layers=(lower, replace(upper, groups=(outer, inner)), last))
    nm.write_unpacked(nm.unpack(workspace), tmp_path / "out")
    recipe = tomllib.loads((tmp_path / "out" / "recipe.toml").read_text(encoding="utf-8"))
    (group,) = recipe["layer"]
    assert (group["name"], group.get("strength", 1.0), group.get("mode", "over")) == ("outer", 0.5, "over")
    assert [one["name"] for one in group["layer"]] == ["bumpy", 'in"ner', "last"]
    assert group["layer"][1]["hidden"] is True
    assert group["layer"][1]["layer"][0]["mode"] == "rnm"
    assert group["layer"][2]["hidden"] is True


def test_pass_through_groups_are_dissolved_in_the_recipe(tmp_path, run):
    group = nm.WorkspaceGroup("kept together", blend_mode="pass through", opacity=0.5, visible=False)
    nm.write_unpacked(nm.unpack(packed(groups=(group,))), tmp_path / "out")
    recipe = tomllib.loads((tmp_path / "out" / "recipe.toml").read_text(encoding="utf-8"))
    assert [(one["name"], one.get("strength", 1.0), one.get("hidden", False)) for one in recipe["layer"]] == [
        ("bumpy", 0.5, True),
        ("small", 1.0, False),
    ]


@pytest.mark.parametrize("ending", ["psd", "ora", "tif", "exr"])
def test_the_recipe_recomposes_the_layers(tmp_path, run, ending):
    maps = [bumpy(), nm.PackedMap(bumpy(60, 50, 1, "small.png"), left=-7, top=20, mode="rnm", group=("kept", "deep"))]
    nm.write_workspace(nm.pack(maps, nm.PackOptions(bits=32 if ending == "exr" else 16)), tmp_path / f"w.{ending}")
    assert run("compose", "unpack", tmp_path / f"w.{ending}", "-o", tmp_path / "out").code == 0
    done = run("compose", "stack", tmp_path / "out" / "recipe.toml", "-o", tmp_path / "out.exr")
    assert done.code == 0, done.err
    below, small = bumpy(), bumpy(60, 50, 1)
    place = nm.LayerOptions(at="-7px,20px", anchor="top-left", mode="rnm")
    expected = nm.paste(below, [nm.Layer(small, place)]).normal_map
    found = nm.read_normal_map(tmp_path / "out.exr")
    assert np.abs(found.normals - expected.normals)[bumpy().coverage > 0.1].max() < 1e-3


def test_unsafe_layer_names_become_safe_file_names():
    hostile = [
        "../x",
        "a/b",
        "A/B",
        "con",
        "NUL.png",
        "",
        "..",
        "\0\n",
        "x" * 400,
        "é" * 400,
        "😀",
        "C:\\x",
        "~",
        " . ",
    ]
    found = safe_names(hostile)
    assert len({name.casefold() for name in found}) == len(hostile)
    for name in found:
        assert name
        assert not set(name) & set('/\\:*?"<>|\0\n')
        assert name not in (".", "..")
        assert name.casefold().partition(".")[0] not in ("con", "nul")
        assert len(name.encode()) <= 110
        assert name == name.strip(" .")
    assert safe_names(["中文", "détail 2"]) == ["中文", "détail 2"]


def test_hostile_layer_names_stay_in_the_folder(tmp_path, tree):
    workspace = packed()
    names = ["../../evil", 'a"]\nb = "'] if len(workspace.layers) == 2 else []
    layers = [replace(layer, name=name) for layer, name in zip(workspace.layers, names, strict=True)]
    nm.write_unpacked(nm.unpack(replace(workspace, layers=tuple(layers))), tmp_path / "out")
    assert all(name == "out" or name.startswith("out/") for name in tree())
    recipe = tomllib.loads((tmp_path / "out" / "recipe.toml").read_text(encoding="utf-8"))
    assert [layer["name"] for layer in recipe["layer"]] == ["../../evil", 'a"]b = "']
    assert all((tmp_path / "out" / layer["file"]).is_file() for layer in recipe["layer"])


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("pack", "base.exr"), 2, "no output given: add one, such as -o work.psd"),
        (("pack", "base.exr", "-o", "w.png"), 2, r"ends in \.png; a workspace is written as"),
        (("pack", "base.exr", "-o", "w.psd", "--bits", "32"), 2, r"--bits 32 is not supported"),
        (("pack", "base.exr", "-o", "w.psd", "--bits", "12"), 2, "--bits 12: use 8 or 16"),
        (("pack", "base.exr", "-o", "w.psd", "--half"), 2, "--half is for EXR"),
        (("pack", "base.exr", "-o", "w.exr", "--half", "--bits", "16"), 2, "--half: applies to EXR only"),
        (("pack", "base.exr", "-o", "w.psd", "--at", "3"), 2, "--at 3: expected 2 distances"),
        (
            ("pack", "base.exr", "-o", "w.psd", "--at", "999999px,0"),
            2,
            "is placed at 999999, 0; positions must be within 30000 px",
        ),
        (("pack", "base.exr", "-o", "w.psd", "--name", "a", "--name", "b"), 2, "--name: given 2 times for 1 maps"),
        (("pack", "base.exr", "-o", "no/w.psd"), 5, "the folder no does not exist|does not exist; create it first"),
        (("pack", "base.exr", "-o", "base.exr"), 5, "already exists"),
        (("pack", "missing.exr", "-o", "w.psd"), 3, "no such file"),
        (("pack", "base.exr", "-o", "w.psd", "--mask", "detail.png"), 3, "coloured|colour picture"),
        (("unpack", "base.exr"), 2, "no output given: add one, such as -o maps"),
        (("unpack", "missing.psd", "-o", "out"), 3, "no such file"),
        (("unpack", "base.exr", "-o", "detail.png"), 5, "is a file; layers are unpacked into a folder"),
        (("unpack", "base.exr", "-o", "no/out"), 5, "does not exist; create it first"),
        (("unpack", "base.exr", "-o", "out", "--report", "r.txt"), 2, r"a report is written as \.json"),
        (("unpack", "base.exr", "-o", "out", "--max-megapixels", "0"), 2, "must be greater than zero"),
        (("unpack", "base.exr", "-o", "out", "--max-megapixels", "0.001"), 4, "more than the limit of 0.001"),
        (("unpack", "detail.png", "-o", "out"), 3, "is not a workspace in a supported format"),
        (("unpack", "-", "-o", "out"), 2, "a layered file cannot be read from standard input"),
    ],
)
def test_wrong_arguments_are_refused(maps, refused, monkeypatch, words, code, message):
    monkeypatch.chdir(maps)
    refused(code, message, "compose", *words)


def test_inputs_are_not_overwritten(maps, run, refused):
    flags = ("-o", maps / "base.exr", "--overwrite")
    refused(2, "is also an input", "compose", "pack", maps / "base.exr", *flags)
    run("compose", "pack", maps / "base.exr", "-o", maps / "work.exr", "--name", "work")
    words = ("unpack", maps / "work.exr", "-o", maps, "--overwrite")
    refused(5, "is both input and output; unpack it into another folder", "compose", *words)


def test_nothing_is_overwritten_and_nothing_half_written(maps, run, refused):
    run("compose", "pack", maps / "base.exr", "-o", maps / "w.psd")
    assert run("compose", "unpack", maps / "w.psd", "-o", maps / "out").code == 0
    refused(5, "already exists", "compose", "unpack", maps / "w.psd", "-o", maps / "out")
    (maps / "out" / "recipe.toml").unlink()
    refused(5, "already exists", "compose", "unpack", maps / "w.psd", "-o", maps / "out")
    assert run("compose", "unpack", maps / "w.psd", "-o", maps / "out", "--overwrite").code == 0
