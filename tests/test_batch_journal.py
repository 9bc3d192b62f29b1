"""The journal of a batch: what is finished, what the batch may replace, and damage."""

import json
import re
from pathlib import Path

import pytest

import nmaptool as nm
from nmaptool.core.errors import InputError, OutputError
from nmaptool.io.sets.journal import JOURNAL_NAME, Journal, default_journal
from nmaptool.types.batch import BatchItem


@pytest.fixture
def place(tmp_path):
    """A folder with the journal of a batch in it."""
    return tmp_path / "out" / JOURNAL_NAME


def item_of(place, recipe="1", outputs=("out/a.stl",)):
    return BatchItem("relief", (), {}, ("a.png",), (), outputs, recipe, str(place.parent.parent))


def write(place, name="a.stl", data=b"x"):
    path = place.parent / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def result(outputs=("out/a.stl",), status="done", code=0):
    return nm.BatchResult(("a.png",), outputs, code, status)


def finish(place, item, name="a.stl", data=b"x", **more):
    """Let an item begin and end in a batch of its own."""
    with Journal(place).open() as journal:
        assert journal.owns(item)
        journal.begin(item)
        write(place, name, data)
        journal.end(item, result(tuple(f"out/{each}" for each in (name,)), **more))


def state(place, item):
    """Whether a later batch takes the item for finished, and whether it may replace its outputs."""
    with Journal(place).open() as journal:
        return journal.finished(item) is not None, journal.owns(item)


def test_a_finished_item_is_known_while_its_outputs_exist(place):
    item = item_of(place)
    assert state(place, item) == (False, True)
    finish(place, item, code=1)
    with Journal(place).open() as journal:
        assert journal.finished(item) == nm.BatchResult(("a.png",), ("out/a.stl",), 1, "skipped", recipe="1")
        assert journal.finished(item_of(place, "2")) is None
    write(place, data=b"changed by hand")
    assert state(place, item) == (True, False)
    (place.parent / "a.stl").unlink()
    assert state(place, item) == (False, True)


def test_outputs_that_another_item_has_written_since_are_not_finished(place):
    finish(place, item_of(place, "1"))
    finish(place, item_of(place, "2"), data=b"other")
    assert state(place, item_of(place, "1")) == (False, True)
    assert state(place, item_of(place, "2")) == (True, True)


def test_an_item_that_did_not_end_may_be_replaced_and_is_not_finished(place):
    item = item_of(place)
    finish(place, item)
    other = item_of(place, "2")
    with Journal(place).open() as journal:
        journal.begin(other)
    write(place, data=b"of the run that was killed")
    assert state(place, item) == (False, True)
    with Journal(place).open() as journal:
        journal.end(other, result(status="failed", code=3))
    assert state(place, item) == (True, False)


def test_foreign_files_are_not_owned(place):
    write(place)
    assert state(place, item_of(place)) == (False, False)
    folder = item_of(place, outputs=("out/maps",))
    write(place, "maps/mine.txt")
    assert state(place, folder) == (False, False)


def test_a_folder_is_owned_if_everything_in_it_is(place):
    item = item_of(place, outputs=("out/maps",))
    finish(place, item, "maps/base.exr")
    with Journal(place).open() as journal:
        assert journal.finished(item).outputs == (str(Path("out/maps/base.exr")),)
        assert journal.owns(item)
    write(place, "maps/mine.txt")
    assert state(place, item) == (True, False)


def test_a_store_is_owned_while_its_contents_stay(place):
    item = item_of(place, outputs=("out/a.zarr",))
    with Journal(place).open() as journal:
        journal.begin(item)
        write(place, "a.zarr/c/0/0")
        journal.end(item, result(("out/a.zarr",)))
    assert state(place, item) == (True, True)
    write(place, "a.zarr/c/0/0", b"changed")
    assert state(place, item) == (True, False)


def test_the_folder_of_the_outputs_can_be_moved(place, tmp_path):
    finish(place, item_of(place))
    place.parent.rename(tmp_path / "moved")
    moved = item_of(place, outputs=("moved/a.stl",))
    assert state(tmp_path / "moved" / JOURNAL_NAME, moved) == (True, True)


def test_an_incomplete_last_line_is_ignored_and_ended(place):
    finish(place, item_of(place))
    whole = place.read_bytes()
    place.write_bytes(whole + b'{"state": "done", "rec')
    assert state(place, item_of(place)) == (True, True)
    finish(place, item_of(place, "2"))
    lines = place.read_bytes().splitlines()
    assert [json.loads(line)["state"] for line in lines[:2] + lines[3:]] == ["begun", "done"] * 2


@pytest.mark.parametrize("text", ["not a journal\n", "{}\n", "[]\n", '{"recipe": 1, "state": "done"}\n'])
def test_any_other_file_is_refused_and_kept(place, text):
    write(place, JOURNAL_NAME, text.encode())
    with (
        pytest.raises(InputError, match=r"is not a journal of nmap batch; name another `journal`"),
        Journal(place).open(),
    ):
        pass
    assert place.read_text(encoding="utf-8") == text


def test_a_journal_serves_one_batch_at_a_time(place):
    message = rf"^{re.escape(str(place))}: another batch is using this journal; wait for its end, or name another"
    with Journal(place).open(), pytest.raises(OutputError, match=message), Journal(place).open():
        pass
    with Journal(place).open():
        pass


def test_a_journal_that_cannot_be_written_is_refused(place, tmp_path):
    (tmp_path / "out").write_text("a file", encoding="utf-8")
    with pytest.raises(OutputError, match=r"the journal cannot be written \("), Journal(place).open():
        pass


def test_the_journal_lies_in_the_deepest_folder_of_all_outputs(tmp_path):
    def place(*outputs):
        return default_journal([BatchItem("relief", (), {}, (), (), outputs, "", str(tmp_path))])

    assert place("out/a.stl", "out/b.stl") == tmp_path / "out" / JOURNAL_NAME
    assert place("out/x/a.stl", "out/y/b.stl") == tmp_path / "out" / JOURNAL_NAME
    assert place("out/maps") == tmp_path / "out" / JOURNAL_NAME
    assert place() is None


def test_without_a_file_nothing_is_finished(place):
    with Journal(None).open() as journal:
        item = item_of(place)
        journal.begin(item)
        journal.end(item, result())
    assert not place.exists()
