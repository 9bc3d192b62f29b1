"""Tables of arguments that the command line refuses, and simulated failures."""

import shlex
import sys

import pytest

from nmaptool.core.errors import OutputError


def bad_words(table):
    """Parametrize a test with each (words, pattern) of a table; the test gets the words as a list."""
    return pytest.mark.parametrize(
        ("words", "pattern"), [pytest.param(shlex.split(words), pattern, id=words) for words, pattern in table]
    )


LONG_NAMES = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows takes a name that is too long for a missing one"
)


def bad_targets(table):
    """Parametrize a test with each target in a table of {exit code: {target and flags: pattern}}."""
    return pytest.mark.parametrize(
        ("code", "target", "pattern"),
        [
            pytest.param(code, target, pattern, id=target[:25], marks=[LONG_NAMES] if len(target) > 255 else [])
            for code, patterns in table.items()
            for target, pattern in patterns.items()
        ],
    )


def fail_with(error):
    """Return a function that raises an error for any arguments."""

    def fail(*_, **__):
        raise error

    return fail


def disk_that_fills(monkeypatch, module, good=0):
    """Let ``good`` pictures be written, then fail halfway through each; return a list of the paths that were begun."""
    begun, write = [], module.write_pictures

    def failing(pictures, path):
        begun.append(path)
        if len(begun) <= good:
            return write(pictures, path)
        path.write_bytes(bytes(99))
        raise OutputError(f"{path}: cannot be written (is the disk full?)")

    monkeypatch.setattr(module, "write_pictures", failing)
    return begun
