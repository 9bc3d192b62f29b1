"""How many processes share the items of a batch: by the memory that they need."""

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.errors import UsageError
from nmaptool.io.pictures.picture_size import picture_size
from nmaptool.sets.planning import PROCESS_BYTES, Shift, needed_bytes, shifts
from nmaptool.types.batch import BatchItem

GB = 10**9


def item_of(*files):
    return BatchItem("relief", (), {}, files[:1], files, (), "", ".")


def plan(needed, free=16, machine=8, **options):
    sizes = {number: int(size * GB) for number, size in enumerate(needed)}
    return shifts(sizes, nm.BatchOptions(**options), free=free * GB, machine=machine)


@pytest.mark.parametrize(
    ("needed", "more", "planned"),
    [
        ([1] * 20, {}, [(8, 1, 20)]),
        ([1] * 3, {}, [(3, 2, 3)]),
        ([1], {}, [(1, 8, 1)]),
        ([3] * 20, {}, [(4, 2, 20)]),
        ([40], {}, [(1, 8, 1)]),
        ([1] * 9 + [5, 5, 40], {}, [(8, 1, 9), (2, 4, 2), (1, 8, 1)]),
        ([1] * 20, {"workers": 3}, [(3, 2, 20)]),
        ([1] * 20, {"workers": 16}, [(8, 1, 20)]),
        ([0.5] * 20, {"workers": 16}, [(16, 1, 20)]),
        ([1] * 20, {"memory_limit": "4GB"}, [(4, 2, 20)]),
    ],
)
def test_processes_and_threads_follow_the_memory(needed, more, planned):
    found = plan(needed, **more)
    assert [(shift.workers, shift.threads, len(shift.items)) for shift in found] == planned
    assert sorted(number for shift in found for number in shift.items) == list(range(len(needed)))
    assert all(isinstance(shift, Shift) for shift in found)


def test_sizes_come_from_headers_alone(tmp_path, png, picture, dome, codes):
    d = dome()
    files = {
        png(tmp_path / "a.png", codes(d.normals)): (96, 96),
        png(tmp_path / "cut.png", codes(d.normals), cut=9000): (96, 96),
        picture(tmp_path / "a.exr", d.normals[:64]): (96, 64),
        picture(tmp_path / "a.tif", d.normals[:, :80]): (80, 96),
    }
    np.save(tmp_path / "a.npy", d.normals)
    files[tmp_path / "a.npy"] = (96, 96)
    assert {path: picture_size(path) for path in files} == files
    (tmp_path / "no.png").write_text("hello", encoding="utf-8")
    for name in ("no.png", "missing.png", "."):
        assert picture_size(tmp_path / name) is None


def test_needed_memory_grows_with_the_pictures(tmp_path, png):
    small, large = (str(png(tmp_path / f"{size}.png", np.zeros((size, size, 3), np.uint8))) for size in (1000, 2000))
    assert needed_bytes(item_of()) == PROCESS_BYTES
    one = needed_bytes(item_of(large)) - PROCESS_BYTES
    assert 100 * 2000**2 < one < 250 * 2000**2
    assert needed_bytes(item_of(small, large)) - PROCESS_BYTES == one + 24 * 10**6
    mesh = tmp_path / "a.ply"
    mesh.write_bytes(bytes(10**6))
    assert needed_bytes(item_of(str(mesh))) > PROCESS_BYTES + 10**7


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"workers": 0}, "`workers=0`: must lie between 1 and 1024, such as 4"),
        ({"memory_limit": "8"}, "`memory_limit='8'`: expected a number with a unit"),
        ({"scheduler": "here"}, "`scheduler='here'`: must be the address of a scheduler, such as tcp://10.0.0.5:8786"),
        ({"scheduler": "tcp://a:1", "workers": 2}, "`workers`: a cluster has its own workers; leave it out with"),
    ],
)
def test_options_that_are_not_accepted(options, message):
    with pytest.raises(UsageError, match=f"^{message}"):
        nm.BatchOptions(**options)
