"""The line of a text mesh that cannot be read is named."""

import mesh_files as files
import pytest

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.reader import read_mesh

DAMAGED = r"file is truncated or damaged; export it again$"


@pytest.fixture
def refused(tmp_path):
    """``refused("a.obj", data, pattern)``: those bytes give an InputError of one line."""

    def call(name, data, pattern):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=pattern) as caught:
            read_mesh(tmp_path / name)
        assert str(caught.value).startswith(f"{tmp_path / name}: ")
        assert "\n" not in str(caught.value)

    return call


def test_invalid_numbers_are_refused(refused):
    few = "where 3 are needed"
    for line, fault in (
        (b"v 1 2\n", f"has 2 numbers {few}"),
        (b"v 1 2 x\n", "has 'x' where a number is needed"),
        (b"v\n", f"has 0 numbers {few}"),
        (b"v 1 2 # 3\n", f"has 2 numbers {few}"),
        (b"v 1 2 \\\n\xe9\n", r"has '\\xe9' where a number is needed"),
        (b"v 1 2 1_0\n", "has '1_0' where a number is needed"),
        (b"f 1 2 x/1\n", "has 'x/1' where a number is needed"),
        (b"f 1.5 2 3\n", "has '1.5' where a number is needed"),
    ):
        refused("{a}.obj", b"\n# x\n" + line + files.obj(), rf": line 3 {fault}: the OBJ {DAMAGED}")
    bad = "has 'x' where a number is needed"
    refused("a.off", files.off().replace(b"1 0 0\n", b"1 x 0\n"), rf": line 4 {bad}: the OFF {DAMAGED}")
    refused("a.off", files.off().replace(b"3 0 2 1", b"3 0 x 1"), rf": line 7 {bad}: the OFF {DAMAGED}")
    data = files.ply(kind="ascii").replace(b"1 0 0\n", b"1 x 0\n")
    refused("a.ply", data, rf": line 12 {bad}: the PLY {DAMAGED}")
    data = files.ascii_stl().replace(b"vertex 1 0 0", b"vertex 1 x 0", 1)
    refused("a.stl", data, rf": line 6 {bad}: the STL {DAMAGED}")
    data = files.ascii_stl().replace(b"      vertex 1 0 0\n", b"", 1)
    refused("a.stl", data, rf": line 2 begins a face with 2 corners instead of 3: the STL {DAMAGED}")


def test_decimal_commas_are_named(refused):
    comma = r"has the number '1,5' with a decimal comma; export it again with decimal points$"
    refused("a.obj", b"v 1,5 2,5 3,5\n" + files.obj(), rf": line 1 {comma}")
    refused("a.off", files.off().replace(b"1 0 0\n", b"1,5 0 0\n"), rf": line 4 {comma}")
    refused("a.ply", files.ply(kind="ascii").replace(b"1 0 0\n", b"1,5 0 0\n"), rf": line 12 {comma}")
    refused("a.stl", files.ascii_stl().replace(b"vertex 1 0 0", b"vertex 1,5 0 0", 1), rf": line 6 {comma}")
