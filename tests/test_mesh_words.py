"""Mesh text is parsed in pieces that may end anywhere, and only valid numbers are accepted."""

import subprocess
import sys

import mesh_files as files
import numpy as np
import pytest
from mesh_files import FACES, VERTICES

from nmaptool.core.errors import InputError
from nmaptool.io.meshes import words
from nmaptool.io.meshes.reader import read_mesh

RELATIVE = (
    b"v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3 1 0 0\nf -4 -2 -3 # one\nf 1/7/1 2//3 -1/2\nvn 0 0 1\nf -4 -1 -2 -3\n" * 9
)


@pytest.mark.parametrize("size", [1, 7, 40, 200])
@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.obj", RELATIVE),
        ("a.off", files.off(VERTICES, [*FACES, [0, 1, 2, 3]])),
        ("a.stl", files.ascii_stl() + files.ascii_stl(VERTICES + 5)),
    ],
)
def test_pieces_of_any_size_give_the_same_mesh(tmp_path, monkeypatch, name, data, size):
    (tmp_path / name).write_bytes(data)
    whole = read_mesh(tmp_path / name)
    monkeypatch.setattr(words, "_BLOCK", size)
    assert len(list(words.blocks(data))) > len(data) // (size + 60)
    pieces = read_mesh(tmp_path / name)
    assert np.array_equal(whole.vertices, pieces.vertices)
    assert np.array_equal(whole.faces, pieces.faces)


@pytest.mark.parametrize("text", [b"", b"a", b"a\nbb\nccc", b"a\nbb\n", b"\n\n\n", b"abcdefgh"])
def test_pieces_contain_the_whole_text(monkeypatch, text):
    monkeypatch.setattr(words, "_BLOCK", 3)
    pieces = list(words.blocks(text))
    assert b"".join(pieces) == text
    assert all(piece.endswith(b"\n") for piece in pieces[:-1])


def test_lines_are_split_into_words():
    found = words.Words.of(b"\n v 1  2\t3 #x\n\n\x0bf 4/5 6")
    spelled = [found.data[b:e].tobytes() for b, e in zip(found.begin, found.end, strict=True)]
    assert spelled == [b"v", b"1", b"2", b"3", b"#x", b"f", b"4/5", b"6"]
    assert found.first.tolist() == [0, 5]
    assert found.count.tolist() == [5, 3]
    assert found.starts_with(b"f").tolist() == [False, True]
    assert found.cut(found.begin[[1, 6]], found.end[[2, 7]]).split() == [b"1", b"2", b"4/5", b"6"]


def test_numbers_are_read_as_c_reads_them():
    assert words.numbers(b" 1 -2.5e-1\n+.5\t7. ", np.float64).tolist() == [1, -0.25, 0.5, 7]
    assert np.array_equal(
        words.numbers(b"NaN -inf Infinity nan(ind) 1e400", np.float64),
        [np.nan, -np.inf, np.inf, np.nan, np.inf],
        equal_nan=True,
    )
    assert words.numbers(b"  ", np.int64).tolist() == []


@pytest.mark.parametrize("word", [b"x", b"1,5", b"1_0", b"0x10", b"1e", b"--1", b"1.5", b"9" * 19, b"-" + b"9" * 30])
def test_words_that_are_not_integers_are_refused(word):
    with pytest.raises(ValueError, match=r"^(string or file could not be read.*)?$"):
        words.numbers(b"1 " + word + b" 2", np.int64)
    with pytest.raises(ValueError, match=r"^$"):
        words.numbers(b"1 2", np.int64, 3)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.off", files.off().replace(b"1 0 0\n", b"1_0 0 0\n")),
        ("a.off", files.off().replace(b"1 0 0\n", b"nan(ind) 0 0\n")),
        ("a.off", files.off().replace(b"3 0 2 1", b"+3 0 2 1")),
        ("a.off", files.off().replace(b"3 0 2 1", b"2 0 x 1")),
        ("a.obj", files.obj().replace(b"v 1 0 0", b"v 1\xb2 0 0")),
        ("a.obj", files.obj().replace(b"v 1 0 0", b"v 1\f0 0 0")),
        ("a.obj", files.obj().replace(b"v 1 0 0", b"v \v1 0 0")),
        ("a.obj", files.obj() + b"f 1 x\n"),
        ("a.stl", files.ascii_stl().replace(b"vertex 1 0 0", b"vertex vertex 0 0", 1)),
        ("a.stl", files.ascii_stl().replace(b"endloop", b"vertex", 1)),
    ],
)
def test_damaged_words_are_refused(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=r"file is truncated or damaged; export it again$"):
        read_mesh(tmp_path / name)


def test_a_signed_zero_is_not_a_vertex_index_of_an_obj(tmp_path):
    (tmp_path / "a.obj").write_bytes(files.obj() + b"f 1 2 +0\n")
    with pytest.raises(InputError, match=r"refers to vertex 0, but OBJ files count from 1; export it again$"):
        read_mesh(tmp_path / "a.obj")


def test_reading_does_not_load_a_mesh_library(tmp_path):
    for ending, data in files.good().items():
        (tmp_path / f"a.{ending}").write_bytes(data)
    script = (
        "import pathlib, sys; from nmaptool.io.meshes.reader import read_mesh\n"
        "print(*[len(read_mesh(p).faces) for p in pathlib.Path(sys.argv[1]).iterdir()], 'trimesh' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script, tmp_path], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["4"] * 6 + ["False"]
