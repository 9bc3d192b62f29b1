"""Tables of what the command line refuses, and failures that tests bring about."""

import shlex
import sys

import pytest

from nmaptool.core.errors import OutputError


def bad_words(table):
    """A test for each (words, pattern) of a table; the test gets the words as a list."""
    return pytest.mark.parametrize(
        ("words", "pattern"), [pytest.param(shlex.split(words), pattern, id=words) for words, pattern in table]
    )


LONG_NAMES = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows takes a name that is too long for a missing one"
)


def bad_targets(table):
    """A test for each target in a table of {exit code: {target and flags: pattern}}."""
    return pytest.mark.parametrize(
        ("code", "target", "pattern"),
        [
            pytest.param(code, target, pattern, id=target[:25], marks=[LONG_NAMES] if len(target) > 255 else [])
            for code, patterns in table.items()
            for target, pattern in patterns.items()
        ],
    )


def fail_with(error):
    """A function that raises an error whatever it is given."""

    def fail(*_, **__):
        raise error

    return fail


def disk_that_fills(monkeypatch, module, good=0):
    """From the picture after so many ``good`` ones, writing ends with bytes left behind; a list of what was begun."""
    begun, write = [], module.write_pictures

    def failing(pictures, path):
        begun.append(path)
        if len(begun) <= good:
            return write(pictures, path)
        path.write_bytes(bytes(99))
        raise OutputError(f"{path}: cannot be written (is the disk full?)")

    monkeypatch.setattr(module, "write_pictures", failing)
    return begun
