"""Randomly damaged workspace files are read, or refused in one line."""

import random

import numpy as np
import pytest
from workspace_cases import bumpy

import nmaptool as nm


def damaged(data, chance):
    raw = bytearray(data)
    kind = chance.random()
    if kind < 0.2:
        return raw[: chance.randrange(len(raw))]
    if kind < 0.5:
        for _ in range(chance.choice((1, 2, 5, 20))):
            raw[chance.randrange(len(raw))] = chance.randrange(256)
    elif kind < 0.75:  # in the file structure
        for _ in range(chance.choice((1, 2, 4))):
            raw[chance.randrange(min(len(raw), 600))] = chance.choice((0, 1, 127, 128, 255))
    elif kind < 0.9:
        at = chance.randrange(len(raw))
        raw[at : at + 4] = chance.choice((b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff", b"\0\0\xff\xff"))
    else:
        at = chance.randrange(len(raw))
        end = min(len(raw), at + chance.randrange(1, 200))
        raw[at:end] = raw[at:end] * chance.choice((0, 2))
    return raw


@pytest.mark.parametrize(
    ("name", "bits"), [("a.psd", 16), ("a.psd", 8), ("a.psb", 16), ("a.ora", 16), ("a.tif", 16), ("a.exr", 32)]
)
def test_damaged_workspaces_are_read_or_refused_in_one_line(tmp_path, capfd, trials, name, bits):
    runs = trials(150)
    mask = np.random.default_rng(0).random((30, 20)).astype(np.float32)
    maps = [bumpy(40, 50), nm.PackedMap(bumpy(30, 20, 1), left=-5, top=20, mask=mask, group=("a", "b"))]
    path = tmp_path / name
    nm.write_workspace(nm.pack(maps, nm.PackOptions(bits=bits)), path)
    data = path.read_bytes()
    chance = random.Random(bits)
    refused = 0
    for _ in range(runs):
        path.write_bytes(damaged(data, chance))
        try:
            nm.unpack(nm.read_workspace(path, max_megapixels=2.0))
        except (nm.InputError, nm.LimitError) as error:
            refused += 1
            assert str(error).startswith(str(path))
            assert "\n" not in str(error)
    assert refused > runs / 10
    assert capfd.readouterr() == ("", "")  # no decoder prints anything
