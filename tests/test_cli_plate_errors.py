"""Plates of `nmap relief` that cannot be made, and recipes that cannot be saved: one line about flags."""

import pytest
from motif_cases import MOTIFS

import nmaptool as nm

COIN = '[[layer]]\nfile = "dome.exr"\n\n[plate]\nshape = "round"\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the map of a dome and a recipe of a coin, which is the current one."""
    nm.write_normal_map(MOTIFS["dome"](), tmp_path / "dome.exr")
    (tmp_path / "coin.toml").write_text(COIN, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("code", "words", "said"),
    [
        (
            2,
            ["-", "--save-recipe", "a.toml"],
            r"--save-recipe: a recipe names its map; give a file instead of standard",
        ),
        (2, ["dome.exr", "--save-recipe", "a.json"], r"a\.json: a recipe is written as \.toml"),
        (2, ["dome.exr", "--save-recipe", "-", "--json"], r"--save-recipe and --json both print to standard output"),
        (
            2,
            ["coin.toml", "--save-recipe", "maps/a.toml"],
            r"--save-recipe: file names in coin\.toml are relative to its",
        ),
        (3, ["no.exr", "--save-recipe", "a.toml"], r"no\.exr: no such file"),
        (3, ["dome.exr", "--shape", "no.svg", "--save-recipe", "a.toml"], r"no\.svg: no such file"),
        (
            3,
            ["dome.exr", "--shape", "round", "--text", "A", "--font", "Nope", "--save-recipe", "-"],
            r"font 'Nope': is not",
        ),
    ],
)
def test_recipes_that_cannot_be_saved(folder, refused, code, words, said):
    (folder / "maps").mkdir()
    refused(code, said, "relief", *words)


@pytest.mark.parametrize(
    ("code", "flags", "said"),
    [
        (2, ["--shape", "star"], r"--shape star: use rect, round, oval, mask or an SVG file, such as shield\.svg"),
        (2, ["--margin", "1mm"], r"--margin 1mm: needs a plate, such as --shape round"),
        (2, ["--frame", "1mm"], r"--frame: needs a plate, such as --shape round"),
        (2, ["--text", "ANNO"], r"--text: needs a plate, such as --shape round"),
        (2, ["--preset", "coin", "--text-size", "2mm"], r"--text-size: needs a text, such as --text 'ANNO MMXXVI'"),
        (2, ["--shape", "round", "--frame-height", "1mm"], r"--frame-height 1mm: needs --frame, such as --frame 3mm"),
        (2, ["--preset", "coin", "--corner", "1mm"], r"--corner 1mm: is for --shape rect, not round"),
        (
            2,
            ["--preset", "coin", "--engrave", "--emboss"],
            r"--engrave and --emboss exclude each other; give one of them",
        ),
        (2, ["--preset", "coin", "--hole", "3mm"], r"--hole 3mm: expected DIAMETER@ACROSS,DOWN, such as 4mm@50%,6mm"),
        (
            2,
            ["--preset", "coin", "--text", "A", "--text-inset", "1mm"],
            r"--text-inset 1mm: is for a text along the edge",
        ),
        (2, ["--preset", "coin", "--text", "  "], r"--text ' +': is empty; give at least one letter"),
        (2, ["--preset", "coin", "--background", "cut"], r"--background cut: leaves no plate; use --background plane"),
        (2, ["--preset", "coin", "--pitch", "2%"], r"--pitch 2%: sets the size of a pixel; give it in mm, cm, m or in"),
        (
            2,
            ["--preset", "coin", "--base", "1mm", "--shell", "1mm"],
            r"--base and --shell are two kinds of back; give one",
        ),
        (
            2,
            ["--shape", "round", "--max-error", "1mm", "--triangles", "9k"],
            r"--max-error and --triangles both set how",
        ),
        (3, ["--shape", "no.svg"], r"no\.svg: no such file"),
        (3, ["--preset", "coin", "--frame-profile", "no.svg"], r"no\.svg: no such file"),
        (3, ["--preset", "coin", "--text", "A", "--font", "no.ttf"], r"no\.ttf: no such file"),
        (3, ["--preset", "coin", "--text", "A", "--font", "Nope"], r"font 'Nope': is not installed; give a font file"),
        (3, ["--preset", "coin", "--text", "\u4e2d"], r"\u4e2d"),
        (3, ["--preset", "coin", "--width", "20mm", "--hole", "4mm@30mm,50%"], r"--hole .*4mm@30mm,50%"),
        (
            3,
            ["--preset", "coin", "--width", "20mm", "--frame", "12mm"],
            r"no room is left for the motif on a plate 20 mm wide: frame 12 mm",
        ),
        (3, ["--preset", "coin", "--width", "20mm", "--text", "A" * 99, "--text-path", "arc"], r"--text"),
    ],
)
def test_what_cannot_be_made_is_one_line_about_flags(folder, refused, code, flags, said):
    refused(code, said, "relief", "dome.exr", *flags, "-o", "a.stl")


def test_solid_flags_need_a_mesh(folder, refused, run):
    refused(2, r"--base: is for meshes; name one, such as -o", "relief", "dome.exr", "--base", "2mm", "-o", "a.npy")
    assert 'base = "2mm"' in run("relief", "dome.exr", "--base", "2mm", "--save-recipe", "-").out
