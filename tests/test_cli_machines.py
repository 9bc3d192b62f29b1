"""Printers and mills of `nmap relief --for`: what they set, what is said, and what replaces their values."""

import json

import pytest
from motif_cases import MOTIFS

import nmaptool as nm
from nmaptool.options.plates import MACHINES

WIDTH = ("--width", "20mm", "--height", "1mm")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the map of a ring, which is the current one."""
    nm.write_normal_map(MOTIFS["ring"](), tmp_path / "ring.exr")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def reported(run):
    """The JSON report and the messages of a run that writes nothing."""

    def call(*words):
        done = run("relief", "ring.exr", *WIDTH, *words, "-o", "ring.stl", "--json", "--dry-run")
        assert done.code == 0, done.err
        return json.loads(done.out), done.err

    return call


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_sets_and_prints_its_values(folder, reported, name):
    report, said = reported("--for", name)
    values = MACHINES[name].values
    line = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in values.items())
    assert f"  {name} ({MACHINES[name].description}) sets {line}\n" in said
    assert report["machine"] == {"for": name, "pitch": values["pitch"], "finest": values["finest"]}
    assert report["solid"]["options"]["base"] == values["base"]
    assert report["solid"]["options"]["max_error"] == values["max_error"]
    assert report["pitch_mm"] == pytest.approx(float(values["pitch"].removesuffix("mm")), rel=0.02)
    assert report["solid"]["size_mm"][2] == pytest.approx(1 + float(values["base"].removesuffix("mm")), abs=1e-3)


@pytest.mark.parametrize(
    ("flags", "sets", "given"),
    [
        (["--base", "3mm"], "pitch 0.1mm, max error 0.02mm, finest 0.4mm", "base 3mm"),
        (["--pitch", "0.2mm"], "base 2mm, max error 0.02mm, finest 0.4mm", "pitch 0.2mm"),
        (["--max-error", "0.1mm"], "pitch 0.1mm, base 2mm, finest 0.4mm", "max error 0.1mm"),
        (["--finest", "1mm"], "pitch 0.1mm, base 2mm, max error 0.02mm", "finest 1mm"),
        (["--shell", "1mm"], "pitch 0.1mm, max error 0.02mm, finest 0.4mm", "base not set"),
        (["--triangles", "20k"], "pitch 0.1mm, base 2mm, finest 0.4mm", "max error not set"),
        (["--preset", "coin"], "pitch 0.1mm, max error 0.02mm, finest 0.4mm", "base 4%"),
        (["--preset", "game-prop"], "pitch 0.1mm, base 2mm, finest 0.4mm", "max error not set"),
    ],
)
def test_each_value_can_be_given_instead(folder, reported, flags, sets, given):
    _, said = reported("--for", "fdm-0.4", *flags)
    assert f") sets {sets}; given: {given}\n" in said


def test_a_machine_of_a_recipe_gives_way_to_its_other_keys_and_to_flags(folder, run):
    text = '[relief]\nwidth = "20mm"\nheight = "1mm"\nbase = "1mm"\n[machine]\nfor = "fdm-0.4"\n'
    (folder / "a.toml").write_text(f'{text}finest = "0.5mm"\n[[layer]]\nfile = "ring.exr"\n', encoding="utf-8")
    for flags, line in (
        (
            [],
            "  fdm-0.4 (filament printer with a 0.4 mm nozzle) sets pitch 0.1mm, max error 0.02mm; given: base 1mm",
        ),
        (["--for", "resin-0.05"], ") sets pitch 0.05mm, max error 0.005mm; given: base 1mm, finest 0.5mm"),
        (["--pitch", "0.3mm", "--base", "4mm"], ") sets max error 0.02mm; given: pitch 0.3mm, base 4mm, finest 0.5mm"),
    ):
        done = run("relief", "a.toml", *flags, "-o", "a.stl", "--dry-run")
        assert done.code == 0, done.err
        assert line in done.err


def test_detail_finer_than_the_machine_is_a_warning(folder, reported):
    assert "finer than the 3 mm that cnc-3mm can make" in reported("--for", "cnc-3mm")[1]
    assert "can make" not in reported("--finest", "0.1mm")[1]
    assert "finer than the 4 mm that the machine can make" in reported("--finest", "4mm")[1]


def test_without_a_machine_nothing_is_said_or_changed(folder, reported):
    report, said = reported()
    assert "machine" not in report
    assert "sets" not in said
    assert report["pitch_mm"] == pytest.approx(20 / 96)


def test_faults_of_machines(folder, refused):
    for words, said in (
        (
            ["--for", "lathe"],
            r"--for lathe: use one of fdm-0\.4, resin-0\.05, cnc-3mm, laser-254dpi|Invalid value .*lathe",
        ),
        (["--finest", "3%"], r"--finest 3%: sets the width of the finest detail; give it in mm, cm, m or in"),
        (["--pitch", "0mm"], r"--pitch 0mm: must be greater than zero"),
    ):
        refused(2, said, "relief", "ring.exr", *words, "-o", "a.stl")
    said = (
        r"--pitch 0\.0001.*: would make a picture of \d+ x \d+ px; at most 270 megapixels are possible, so use a larger"
    )
    refused(4, said, "relief", "ring.exr", *WIDTH, "--pitch", "0.0001mm", "-o", "a.stl")


@pytest.mark.parametrize("words", [["--preset", "coin"], ["--for", "laser-254dpi"], ["--pitch", "0.5mm"]])
def test_the_report_has_the_options_as_given_and_says_that_a_size_is_assumed(folder, run, words):
    nm.write_normal_map(nm.NormalMap.from_array(MOTIFS["ring"]().normals, MOTIFS["ring"]().coverage), "bare.exr")
    for more, known in (([], "assumed"), (["--width", "20mm"], "given")):
        done = run("relief", "bare.exr", *words, *more, "--json", "--dry-run")
        assert done.code == 0, done.err
        report = json.loads(done.out)
        assert report["pitch_from"] == known
        assert report["options"]["width"] == (more[1] if more else None)
        assert report["options"]["height"] == ("2%" if "coin" in words else None)
        assert ("100 mm on the longer side is assumed" in done.err) == (known == "assumed")
