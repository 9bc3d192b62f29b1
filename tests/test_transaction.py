"""Output transactions: all files of a run are written or none, and impossible targets are refused before the work."""

import json
import os
import sys

import pytest

from nmaptool.core.errors import LimitError, OutputError, UsageError
from nmaptool.io.interruption import UNFINISHED, Unfinished
from nmaptool.io.output.targets import check_place, place_of
from nmaptool.io.output.transaction import Outputs, Target, wanted

ENDINGS = (".txt",)


def write_text(value, path):
    path.write_text(value, encoding="utf-8")


def plan(places, *, fail_at=None, error=None, **more):
    """A plan of text files, one of which may fail while it is written."""

    def failing(value, path):
        path.write_text("half", encoding="utf-8")
        raise error

    writers = [failing if number == fail_at else write_text for number in range(len(places))]
    targets = [Target(place_of(place), "a note", ENDINGS, write) for place, write in zip(places, writers, strict=True)]
    return Outputs(targets, **more)


def test_targets_are_written_in_the_given_order(tmp_path, tree):
    report = tmp_path / "r.json"
    outputs = plan([tmp_path / "a.txt", tmp_path / "b.txt"], report=report)
    assert outputs.paths == outputs.places == [tmp_path / "a.txt", tmp_path / "b.txt", report]
    assert outputs.names == [str(path) for path in outputs.paths]
    outputs.write("hello", {"outputs": outputs.names})
    assert sorted(tree()) == ["a.txt", "b.txt", "r.json"]
    assert (tmp_path / "b.txt").read_text(encoding="utf-8") == "hello"
    assert report.read_text(encoding="utf-8") == json.dumps({"outputs": outputs.names}, indent=2) + "\n"


def test_shared_preparation_runs_once(tmp_path):
    made = []
    outputs = plan([tmp_path / "a.txt", tmp_path / "b.txt"], prepare=lambda value, facts: made.append(facts) or value)
    outputs.write("hello", {"a": 1})
    assert made == [{"a": 1}]


@pytest.mark.parametrize("fail_at", [0, 1, 2])
@pytest.mark.parametrize(
    ("error", "expected", "message"),
    [
        (OSError(28, "No space left on device"), OutputError, r"\w+\.txt: cannot be written \(No space left on device"),
        (LimitError("too many"), LimitError, "too many"),
        (RuntimeError("broken"), RuntimeError, "broken"),
        (KeyboardInterrupt("now"), KeyboardInterrupt, "now"),
    ],
    ids=["full", "limit", "bug", "interrupted"],
)
def test_a_failure_while_writing_changes_nothing(tmp_path, tree, fail_at, error, expected, message):
    (tmp_path / "old.txt").write_text("precious", encoding="utf-8")
    before = tree()
    new = tmp_path / "made" / "within"
    places = [tmp_path / "old.txt", tmp_path / "new.txt", new / "c.txt"]
    folders = [new.parent, new]
    outputs = plan(places, fail_at=fail_at, error=error, report=tmp_path / "r.json", overwrite=True, folders=folders)
    with pytest.raises(expected, match=message):
        outputs.write("hello", {})
    assert tree() == before


def test_errors_name_the_target_not_its_temporary_file(tmp_path):
    def full(value, path):
        raise OutputError(f"{path}: cannot be written (is the disk full?)")

    outputs = Outputs([Target(tmp_path / "a.txt", "a note", ENDINGS, full)])
    with pytest.raises(OutputError) as told:
        outputs.write("hello")
    assert str(told.value) == f"{tmp_path / 'a.txt'}: cannot be written (is the disk full?)"


@pytest.mark.parametrize("links", [True, False])
def test_renaming_is_undone_if_a_later_target_already_exists(tmp_path, tree, monkeypatch, links):
    """The second file appears during writing, on file systems with and without hard links."""
    if not links:

        def refuse(self, target):
            raise OSError(1, "Operation not permitted")

        monkeypatch.setattr("pathlib.Path.hardlink_to", refuse)

    def late(value, path):
        (tmp_path / "b.txt").write_text("another program's", encoding="utf-8")
        path.write_text(value, encoding="utf-8")

    first, second = (Target(tmp_path / f"{name}.txt", "a note", ENDINGS, late) for name in "ab")
    with pytest.raises(OutputError, match=r"b\.txt: already exists"):
        Outputs([first, second]).write("hello")
    assert sorted(tree()) == ["b.txt"]
    assert (tmp_path / "b.txt").read_text(encoding="utf-8") == "another program's"


@pytest.mark.parametrize("links", [True, False])
def test_replaced_files_are_restored(tmp_path, tree, monkeypatch, links):
    for name in "ab":
        (tmp_path / f"{name}.txt").write_text(f"old {name}", encoding="utf-8")
    before = tree()
    replace = os.replace

    def refuse(self, target):
        raise OSError(1, "Operation not permitted")

    def replaced(self, target):
        if target.name == "b.txt" and self.suffix == ".txt":
            raise OSError(5, "Input/output error")
        replace(self, target)

    monkeypatch.setattr("pathlib.Path.replace", replaced)
    if not links:
        monkeypatch.setattr("pathlib.Path.hardlink_to", refuse)
    with pytest.raises(OutputError, match=r"b\.txt: cannot be written \(Input/output error\)"):
        plan([tmp_path / "a.txt", tmp_path / "b.txt"], overwrite=True).write("hello")
    assert tree() == before


def test_a_leftover_that_cannot_be_removed_does_not_end_a_run(tmp_path, monkeypatch):
    """Windows does not remove a file that another program has open."""
    (tmp_path / "a.txt").write_text("old", encoding="utf-8")

    def refuse(self, missing_ok=False):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.unlink", refuse)
    plan([tmp_path / "a.txt", tmp_path / "b.txt"], overwrite=True).write("new")
    assert [(tmp_path / name).read_text(encoding="utf-8") for name in ("a.txt", "b.txt")] == ["new", "new"]


def test_impossible_targets_are_refused_before_the_work(tmp_path):
    (tmp_path / "old.txt").write_text("precious", encoding="utf-8")
    (tmp_path / "file").write_text("no folder", encoding="utf-8")
    # Windows reports a name that is too long as missing
    too_long = [(OutputError, r"(?i)too long", plan([], folders=[tmp_path / ("n" * 300)]))] * (sys.platform != "win32")
    for error, message, outputs in (
        (UsageError, r"a\.md: a note is written as \.txt$", plan([tmp_path / "a.md"])),
        (UsageError, r"r\.txt: a report is written as \.json", plan([], report=tmp_path / "r.txt")),
        (UsageError, r"a\.txt: is named twice", plan([tmp_path / "a.txt", tmp_path / "sub" / ".." / "a.txt"])),
        (OutputError, r"old\.txt: already exists; give another name", plan([tmp_path / "old.txt"])),
        (OutputError, r"the folder .*none does not exist", plan([tmp_path / "none" / "a.txt"])),
        (OutputError, r"file: is a file; a folder is needed; give another name", plan([], folders=[tmp_path / "file"])),
        (OutputError, r"file is a file, not a folder", plan([], folders=[tmp_path / "file" / "sub"])),
        (OutputError, r"the folder .* does not exist; create", plan([], folders=[tmp_path / "no" / "sub"])),
        *too_long,
    ):
        with pytest.raises(error, match=message):
            outputs.check()
        with pytest.raises(error, match=message):
            outputs.write("hello")
    assert (tmp_path / "old.txt").read_text(encoding="utf-8") == "precious"


def test_rules_are_checked_first_and_targets_are_optional(tmp_path):
    def rule():
        raise UsageError("no such thing")

    with pytest.raises(UsageError, match="no such thing"):
        plan([tmp_path / "a.md"], rules=[rule]).check()
    assert wanted(None, "a note", ENDINGS, write_text) == ()
    check_place(place_of(str(tmp_path / "a.md")), overwrite=False)


def test_a_run_is_complete_once_its_results_are_written(tmp_path):
    UNFINISHED.is_complete = False
    plan([tmp_path / "state.txt"]).write("kept on the way", final=False)
    assert not UNFINISHED.is_complete
    plan([tmp_path / "a.txt"]).write("hello")
    assert UNFINISHED.is_complete


def test_sweeping_removes_only_unfinished_files(tmp_path, tree):
    unfinished = Unfinished()
    full, empty, half = tmp_path / "full", tmp_path / "empty", tmp_path / "half.txt"
    for folder in (full, empty):
        folder.mkdir()
    (full / "kept.txt").write_text("another program's", encoding="utf-8")
    half.write_text("half", encoding="utf-8")
    with unfinished.swept([half, tmp_path / "never.txt"], [full, empty]), unfinished.temporary_folder() as temporary:
        (temporary / "x").write_text("passed on", encoding="utf-8")
        unfinished.sweep()
        assert not temporary.exists()
        assert not half.exists()
        assert not empty.exists()
        assert (full / "kept.txt").read_text(encoding="utf-8") == "another program's"
        temporary.mkdir()  # which a running process removes itself
    half.write_text("finished", encoding="utf-8")
    unfinished.sweep()
    assert half.read_text(encoding="utf-8") == "finished"
