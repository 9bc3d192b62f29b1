"""Find the line of a text that cannot be read, for messages; slow, so only after reading has failed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import NAMES, MeshFile
from nmaptool.io.meshes.words import line_feeds, plain_numbers
from nmaptool.types.shown import counted

_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?,?")
_WHOLE = re.compile(r"[-+]?\d{1,18}")
_LONGEST = 40

_Lines = Iterable[tuple[int, list[str]]]
_Fault = tuple[int, str]


def fault_in(file: MeshFile) -> InputError:
    """The error for a file that cannot be read: with the first line that is invalid, if it is text and has one."""
    finders = {"obj": _in_obj, "off": _in_off, "stl": _in_stl, "ply": _in_ply}
    if file.kind not in finders or not file.is_text:
        return file.damaged
    text = line_feeds(file.read_bytes())
    if file.kind == "ply" and not re.search(rb"^format\s+ascii\b", text[:4096], re.MULTILINE):
        return file.damaged
    found = next(finders[file.kind](_lines(text)), None)
    if found is None:
        return file.damaged
    line, fault = found
    return InputError(f"{file.path}: line {line} {fault.format(kind=NAMES[file.kind])}")


def _lines(text: bytes) -> Iterator[tuple[int, list[str]]]:
    """The number of each line that has words, counted from 1, and its words."""
    for number, line in enumerate(text.split(b"\n"), 1):
        words = line.decode("latin-1").split()
        if words:
            yield number, words


def _numbers(line: int, words: list[str], wanted: int) -> Iterator[_Fault]:
    """The fault of a line that should begin with some numbers."""
    for word in words[:wanted]:
        if word.startswith("#"):
            break
        if not _is_number(word):
            yield line, _no_number(word)
            return
    else:
        if len(words) >= wanted:
            return
    found = next((k for k, word in enumerate(words) if word.startswith("#")), len(words))
    yield line, f"has {counted(found, 'number')} where {wanted} are needed: {_DAMAGED}"


def _no_number(word: str) -> str:
    shown = ascii(word if len(word) <= _LONGEST else f"{word[:_LONGEST]}...").replace("{", "(").replace("}", ")")
    if _DECIMAL_COMMA.fullmatch(word):
        return f"has the number {shown} with a decimal comma; export it again with decimal points"
    return f"has {shown} where a number is needed: {_DAMAGED}"


_DAMAGED = "the {kind} file is truncated or damaged; export it again"


def _is_number(word: str) -> bool:
    try:
        float(plain_numbers(word.encode("latin-1")).decode("latin-1"))
    except ValueError:
        return False
    return "_" not in word


def _in_obj(lines: _Lines) -> Iterator[_Fault]:
    start, kept = 0, list[str]()
    for number, words in lines:
        start, kept = start if kept else number, kept + words
        if kept[-1].endswith("\\"):  # goes on in the next line
            kept[-1] = kept[-1][:-1]
            continue
        whole, kept = [word for word in kept if word], []
        if whole[:1] == ["v"]:
            yield from _numbers(start, whole[1:], 3)
        elif whole[:1] == ["f"]:
            yield from _corners(start, whole[1:])


def _corners(line: int, words: list[str]) -> Iterator[_Fault]:
    for word in words:
        if word.startswith("#"):
            return
        if not _WHOLE.fullmatch(word.partition("/")[0].partition("#")[0]):
            yield line, _no_number(word)
            return


def _in_stl(lines: _Lines) -> Iterator[_Fault]:
    corners, first = 0, 0
    for number, words in lines:
        low = [word.lower() for word in words]
        if low[0] == "facet":
            if corners % 3:
                yield first, f"begins a face with {counted(corners, 'corner')} instead of 3: {_DAMAGED}"
            corners, first = 0, number
        if low[0] == "vertex":
            corners += 1
            yield from _numbers(number, words[1:], 3)
        if low[0] == "endfacet":
            if corners != 3:
                yield first, f"begins a face with {counted(corners, 'corner')} instead of 3: {_DAMAGED}"
            corners = 0


def _in_off(lines: _Lines) -> Iterator[_Fault]:
    header = list[int]()
    for number, words in lines:
        text = " ".join(words).partition("#")[0].split()
        if not header and text and text[0].endswith("OFF"):
            text = text[1:]
        if not text:
            continue
        if not header:
            yield from _numbers(number, text, 2)
            header = [int(word) if _WHOLE.fullmatch(word) else 0 for word in text[:2]]
        elif header[0] > 0:
            header[0] -= 1
            yield from _numbers(number, text, 3)
        else:
            yield from _list(number, text)


def _list(line: int, words: list[str]) -> Iterator[_Fault]:
    """The fault of a line of a number of corners and the corners."""
    if not _WHOLE.fullmatch(words[0]):
        yield line, _no_number(words[0])
    elif len(words) <= int(words[0]):
        yield line, f"declares {counted(int(words[0]), 'corner')} but holds {len(words) - 1}: {_DAMAGED}"
    else:
        yield from _corners(line, words[1 : 1 + int(words[0])])


def _in_ply(lines: _Lines) -> Iterator[_Fault]:
    elements = list[list[int]]()  # rows left, values in a row, whether it has lists
    is_header = True
    for number, words in lines:
        if is_header:
            if words[0] == "element" and len(words) > 2 and _WHOLE.fullmatch(words[2]):
                elements.append([int(words[2]), 0, 0])
            elif words[0] == "property" and elements:
                elements[-1][1] += 1
                elements[-1][2] |= words[1:2] == ["list"]
            is_header = words[0] != "end_header"
            continue
        while elements and elements[0][0] <= 0:
            del elements[0]
        if not elements:
            return
        elements[0][0] -= 1
        yield from _numbers(number, words, 1 if elements[0][2] else elements[0][1])
