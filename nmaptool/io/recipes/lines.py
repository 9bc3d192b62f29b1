"""Find the lines of keys and tables in TOML text, which ``tomllib`` does not report."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field

from nmaptool.composition.recipe_places import Keys
from nmaptool.core.mentions import written_name

# a string of any kind, a line end, a bracket or sign, or part of a bare key, number or date
_TOKEN = re.compile(
    r"""
      \"{3} (?: \\. | (?!\"{3}) [^\\] )*+ \"{3,5}
    | '{3} (?: (?!'{3}) . )*+ '{3,5}
    | " (?: \\. | [^"\\] )*+ "
    | ' [^']*+ '
    | \n
    | [\[\]{}=,]
    | [^][{}=,\s\#"']++
    | (?P<skipped> \#[^\n]*+ | [ \t\r]++ )
    """,
    re.VERBOSE | re.DOTALL,
)


@dataclass(slots=True)
class _Node:
    """A key, a table or an element of a list, with the line where it begins and its contents."""

    line: int
    inner: dict[str | int, _Node] = field(default_factory=dict)

    def to(self, key: str, line: int) -> _Node:
        """Return the node of a key; a new one begins at ``line``."""
        return self.inner.setdefault(key, _Node(line))

    def to_table(self, key: str, line: int) -> _Node:
        """Return the node of a key in a header; for ``[[key]]`` tables, the last one."""
        node = self.to(key, line)
        return node.inner.get(len(node.inner) - 1, node)

    def find(self, key: str | int) -> _Node | None:
        """Return the node of a key, as given or with - for _; None if there is none."""
        found = self.inner.get(key)
        if found is None and isinstance(key, str):
            name = written_name(key)
            same = (n for k, n in self.inner.items() if isinstance(k, str) and k.replace("-", "_") == name)
            return next(same, None)
        return found


class Lines:
    r"""The lines where keys and tables begin.

    Parameters
    ----------
    text : str
        TOML that ``tomllib`` accepts.

    Examples
    --------
    >>> lines = Lines('[canvas]\nsize = "9x9"\n\n[[layer]]\nfile = "a.png"\n')
    >>> lines.of(("canvas", "size")), lines.of(("layer", 0)), lines.of(("layer", 0, "mode"))
    (2, 4, 4)
    """

    def __init__(self, text: str) -> None:
        self._root = _tree(text)

    def of(self, keys: Keys) -> int:
        """Return the line, from 1, of the value at the keys, or of the innermost table around it if it is missing."""
        node = self._root
        for key in keys:
            found = node.find(key)
            if found is None:
                break
            node = found
        return node.line


def _tokens(text: str) -> Iterator[tuple[str, int]]:
    """Yield each token with its line; comments and blanks are skipped."""
    line = 1
    for found in _TOKEN.finditer(text):
        token = found[0]
        if found.lastgroup is None:
            yield token, line
        line += token.count("\n")


def _tree(text: str) -> _Node:
    """Return the tree of everything that the text defines."""
    root = table = _Node(1)  # table: that of the last header
    around: list[_Open] = []  # open lists and inline tables, outermost first
    key, key_line = "", 1  # the part read so far
    is_key = True  # whether the next tokens are a key, not a value
    tokens = _tokens(text)
    for token, line in tokens:
        match token:
            case "\n":
                is_key = is_key or not around
            case "," if around:
                around[-1].index += 1
                is_key = not around[-1].is_list
            case "]" | "}":
                is_key = not around
                if around:
                    around.pop()
            case "[" if is_key:
                table = _header(tokens, root, line)
            case "=" if is_key:
                node = around[-1].node if around else table
                for part in _parts(key):
                    node = node.to(part, key_line)
                key, is_key = "", False
            case _ if is_key:
                key, key_line = key + token, key_line if key else line
            case _:
                if around and around[-1].is_list:
                    node = around[-1].element(line)
                if token in ("[", "{"):
                    around.append(_Open(node, token == "["))
                    is_key = token == "{"
    return root


@dataclass(slots=True)
class _Open:
    """A list or an inline table that is being read, and the index of its next element."""

    node: _Node
    is_list: bool
    index: int = 0

    def element(self, line: int) -> _Node:
        """Return the node of the next element of a list."""
        return self.node.inner.setdefault(self.index, _Node(line))


def _header(tokens: Iterator[tuple[str, int]], root: _Node, line: int) -> _Node:
    """Return the table of a header, whose first bracket has been read."""
    written, is_list = "", False
    for token, _ in tokens:
        if token == "]":
            break
        is_list = is_list or token == "["
        written += token.removeprefix("[")
    *outer, last = _parts(written)
    node = root
    for key in outer:
        node = node.to_table(key, line)
    node = node.to(last, line)
    if is_list:
        return node.inner.setdefault(len(node.inner), _Node(line))
    node.line = line
    return node


def _parts(key: str) -> list[str]:
    """Split a dotted key into its keys, without quotes."""
    if not {'"', "'"} & set(key):
        return key.split(".")
    parts, values = [], tomllib.loads(f"{key} = 0")
    while isinstance(values, dict):
        ((part, values),) = values.items()
        parts.append(part)
    return parts
