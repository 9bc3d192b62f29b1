"""Tables of jobs: TOML and CSV, and the message for everything that may be wrong in them."""

import datetime
from pathlib import Path

import pytest

import nmaptool as nm
from nmaptool.core.errors import InputError, LimitError, UsageError
from nmaptool.io.sets import tables
from nmaptool.io.sets.tables import job_of, read_jobs
from nmaptool_cli.sets.items import items_of

TOML = """
[defaults]
command = "relief"
height = "4mm"
output = "out/{stem}.stl"

[[job]]
inputs = ["maps/*.png"]
per_pixel = true
mu = 0.2

[[job]]
input = "maps/a.png"
output = ["out/a.exr", "out/a.ply"]
height = "5mm"
delta = -3
overwrite = false

[[job]]
command = "compose  convert"
inputs = "maps/b.png"
height = []
output = "out/b.exr"
"""
CSV = """\ufeffcommand;inputs;output;output;--height;per_pixel;mu

relief;maps/a.png;out/a.stl;out/a.exr;4mm;yes;0.2
inspect;"maps/*.png";;;;false
"""


@pytest.fixture
def table(tmp_path):
    """``table(name, text)`` writes a table into a folder with two maps."""
    (tmp_path / "maps").mkdir()
    for name in ("a", "b"):
        (tmp_path / "maps" / f"{name}.png").touch()

    def write(name, text):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return write


def test_a_toml_table_has_defaults_and_a_table_for_each_job(table):
    first, second, third, fourth = items_of(read_jobs(table("jobs.toml", TOML)))
    four = nm.length("4mm")
    assert first.flags == {"height": four, "output": (Path("out/a.stl"),), "per_pixel": True, "mu": 0.2}
    assert (second.arguments, second.outputs) == (("maps/b.png",), ("out/b.stl",))
    outputs = (Path("out/a.exr"), Path("out/a.ply"))
    assert third.flags == {"height": nm.length("5mm"), "output": outputs, "delta": -3}
    assert (fourth.command, fourth.flags) == ("compose convert", {"output": Path("out/b.exr")})
    assert Path(fourth.folder) == table("x", "").parent
    assert fourth.place.endswith("jobs.toml, job 3")


def test_a_csv_table_may_have_semicolons_a_mark_and_repeated_columns(table):
    first, second, third = items_of(read_jobs(table("jobs.csv", CSV)))
    outputs = (Path("out/a.stl"), Path("out/a.exr"))
    assert first.flags == {"output": outputs, "height": nm.length("4mm"), "per_pixel": True, "mu": 0.2}
    assert [(item.command, item.arguments) for item in (second, third)] == [
        ("inspect", ("maps/a.png",)),
        ("inspect", ("maps/b.png",)),
    ]
    assert second.place.endswith("jobs.csv, line 4")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = ]", r"is not valid TOML \(.*line 1.*\)"),
        ("", "is empty"),
        ("[defaults]\n", r"holds no job; add one, such as \[\[job\]\]"),
        ("[jobs]\n", r"has no table 'jobs'; use \[\[job\]\] for each job and \[defaults\]"),
        ("job = 3\n", r"job must be tables with double brackets, \[\[job\]\]"),
        ("defaults = 3\n", r"defaults must be a table, \[defaults\]"),
        ('[[job]]\ninputs = "a.png"\n', "job 1: command is missing; name one, such as command = "),
        (
            '[[job]]\ncommand = "relief"\n',
            'job 1: inputs must be a file name, a pattern or a list of them, such as "maps',
        ),
        ('[[job]]\ncommand = "relief"\ninputs = [3]\n', "job 1: inputs must be a file name"),
        ('[[job]]\ncommand = "relief"\ninputs = "a"\ninput = "b"\n', "job 1: input and inputs are both given"),
        ('[[job]]\ncommand = "relief"\ninputs = "a"\nmu = {}\n', "job 1: mu must be text, a number, true, false or"),
    ],
)
def test_a_toml_table_that_cannot_be_read_is_refused(table, text, message):
    path = table("jobs.toml", text)
    with pytest.raises(InputError, match=rf"jobs\.toml(, |: ){message}"):
        read_jobs(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("inputs,output\n", "the first line must name the columns, command and inputs among them"),
        ("command,inputs\n", "holds no job"),
        ("command,inputs\nrelief,a.png,b\n", "line 2: has 3 cells for 2 columns; put quotes around text with commas"),
        ('command,inputs\nrelief,"a\n', r"line 2: is not valid CSV \(unexpected end of data\)"),
        ("command,inputs,\nrelief,a.png,4mm\n", "line 2: '4mm' stands in a column without a name"),
        ("command,inputs\n,a.png\n", "line 2: command is missing"),
        ("command,inputs\nrelief,\n", "line 2: inputs must be a file name"),
    ],
)
def test_a_csv_table_that_cannot_be_read_is_refused(table, text, message):
    path = table("jobs.csv", text)
    with pytest.raises(InputError, match=rf"jobs\.csv(, |: ){message}"):
        read_jobs(path)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ('command = "carve"\n', "carve: is not a command for a batch"),
        ('command = "relief"\nheigth = "4mm"\n', r"heigth: is not an option of nmap relief; use one of .*height"),
        ('command = "relief"\nheight = true\n', "height: needs a value, not true or false"),
        ('command = "relief"\nper-pixel = 3\n', "per-pixel: needs true or false"),
        ('command = "relief"\nheight = "4"\n', "--height 4: expected a number with a unit"),
        ('command = "relief"\noutput = "{x}.stl"\n', r"\{x\}\.stl: the placeholder \{x\} is unknown"),
    ],
)
def test_a_job_with_a_wrong_option_is_refused_with_its_place(table, row, message):
    path = table("jobs.toml", f'[[job]]\ninputs = "maps/a.png"\n{row}')
    with pytest.raises(UsageError, match=rf"jobs\.toml, job 1: {message}"):
        items_of(read_jobs(path))


def test_other_files_are_refused(table, tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"jobs\.txt: is not a table of jobs; accepted are \.toml and \.csv"):
        read_jobs(table("jobs.txt", ""))
    with pytest.raises(InputError, match=r"none\.csv: no such file"):
        read_jobs(tmp_path / "none.csv")
    (tmp_path / "latin.csv").write_bytes("command,inputs\nrelief,löwe.png\n".encode("latin-1"))
    with pytest.raises(InputError, match=r"latin\.csv: is not UTF-8 text \(byte 23\); save it as UTF-8"):
        read_jobs(tmp_path / "latin.csv")
    monkeypatch.setattr(tables, "_MOST_BYTES", 10)
    with pytest.raises(LimitError, match=r"jobs\.csv: has 0 MB, more than the limit of 0 MB; split it"):
        read_jobs(table("jobs.csv", CSV))


def test_jobs_in_python_are_checked_in_the_same_way(table):
    folder = table("x", "").parent
    with pytest.raises(InputError, match=r"^job 2: command is missing"):
        nm.batch([{"command": "inspect", "inputs": folder / "maps/a.png"}, {"inputs": "a"}])
    with pytest.raises(InputError, match=r"^job 1: when must be text, .* found datetime\.date\(2026, 1, 2\)$"):
        nm.batch([{"command": "inspect", "inputs": "a", "when": datetime.date(2026, 1, 2)}])
    with pytest.raises(InputError, match=r"^job 1: per-pixel is given twice"):
        job_of({"command": "relief", "inputs": "a", "per_pixel": True, "per-pixel": True}, Path(), "job 1")
    with pytest.raises(UsageError, match=r"^job 1: maxx: is not an option of nmap inspect"):
        nm.batch([{"command": "inspect", "inputs": [str(folder / "maps/*.png")], "maxx": 3}])
