"""Parse XML safely: no document type, no entities, bounded depth and size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from nmaptool.core.errors import InputError

DEEPEST = 64
_MOST_ELEMENTS = 100_000


@dataclass
class Element:
    """One element: its tag with prefix, attributes, text directly in it, children."""

    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def walk(self) -> Iterator[Element]:
        """Yield the element and its descendants, depth first."""
        yield self
        for child in self.children:
            yield from child.walk()


def parse_xml(data: bytes, name: str) -> Element:
    """Parse UTF-8 XML.

    Raises
    ------
    InputError
        If it is not well formed, declares a document type or entities, or is too deep or too large.
    """
    root = Element("", {})
    opened = [root]
    pieces: list[list[str]] = [[]]
    count = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if len(opened) > DEEPEST:
            raise InputError(f"{name}: is nested more than {DEEPEST} levels deep; export it again")
        if count > _MOST_ELEMENTS:
            raise InputError(f"{name}: has more than {_MOST_ELEMENTS} elements; export it again")
        element = Element(tag, attributes)
        opened[-1].children.append(element)
        opened.append(element)
        pieces.append([])

    def end(_: str) -> None:
        opened.pop().text = "".join(pieces.pop())

    def text(piece: str) -> None:
        pieces[-1].append(piece)

    def refuse(*_: object) -> None:
        raise InputError(f"{name}: declares a document type or entities, which such files never need; export it again")

    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError:
        raise InputError(f"{name}: is damaged; export it again") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{name}: is damaged; export it again") from None
    return root.children[0]
