"""Texts are free of the phrases in forbidden_phrases.txt; a hit is shown as file:line with the better wording."""

import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_name("forbidden_phrases.txt")
# of Python files, only docstrings, strings and comments are checked
GLOBS = (
    "README.md",
    "CHANGELOG.md",
    "docs/**/*.md",
    "bench/*.md",
    "docs/**/*.py",
    "samples/**/*.py",
    "samples/*.sh",
    "setup.sh",
    "Makefile",
    "bench/**/*.py",
    "cli/**/*.py",
    "nmaptool/**/*.py",
    "nmaptool/**/*.pyi",
    "tests/**/*.py",
)
FILES = sorted({path for pattern in GLOBS for path in ROOT.glob(pattern)})
PROSE = {
    getattr(tokenize, name, -1) for name in ("COMMENT", "STRING", "FSTRING_START", "FSTRING_MIDDLE", "FSTRING_END")
}
GAP = r"""(?:\s|\\n|\#|f?["'])+"""  # a gap between words may span two comment lines or adjacent string literals


def phrases(text):
    """Return (compiled pattern, better wording) for each line."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    pairs = [line.partition("  # ") for line in lines]
    assert [line for line, (_, _, better) in zip(lines, pairs, strict=True) if not better] == []
    return [(re.compile(pattern.strip().replace(" ", GAP), re.IGNORECASE), better) for pattern, _, better in pairs]


def prose(source):
    """Blank everything but comments and strings in a Python source; lines and columns are kept."""
    lines = source.splitlines(keepends=True)
    kept = [[" " if char != "\n" else char for char in line] for line in lines]
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in PROSE:
            continue
        (first, start), (last, end) = token.start, token.end
        for number in range(first, last + 1):
            line = lines[number - 1]
            part = slice(start if number == first else 0, end if number == last else len(line))
            kept[number - 1][part] = line[part]
    return "".join("".join(line) for line in kept)


def hits(text, forbidden):
    """Return (line, phrase as written, better wording) for each hit."""
    found = []
    for pattern, better in forbidden:
        for match in pattern.finditer(text):
            words = re.sub(GAP, " ", match[0])
            found.append((text.count("\n", 0, match.start()) + 1, words, better))
    return sorted(found)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_texts_are_free_of_forbidden_phrases(path):
    text = path.read_text(encoding="utf-8")
    found = hits(prose(text) if path.suffix == ".py" else text, phrases(LIST.read_text(encoding="utf-8")))
    name = path.relative_to(ROOT)
    assert [f'{name}:{line}: "{words}": better: {better}' for line, words, better in found] == []


def test_every_glob_finds_files():
    assert [pattern for pattern in GLOBS if not list(ROOT.glob(pattern))] == []


def test_no_phrase_is_listed_twice():
    patterns = [pattern.pattern for pattern, _ in phrases(LIST.read_text(encoding="utf-8"))]
    assert len(patterns) > 70
    assert sorted(set(patterns)) == sorted(patterns)


RIDDLE = phrases("# a comment\n\ngreen (?:is|are) its leaves  # its leaves are green\n")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("Green is its leaves.", 1),
        ("x\nGreen is\nits leaves.", 2),
        ('"""Title.\n\n    Green are\n    its leaves.\n    """\n', 3),
        ("x = 1\n# green is\n# its leaves\n", 2),
        ('say(\n    "green "\n    f"is its leaves {x}"\n)\n', 2),
        ('say("green is\\nits leaves")\n', 1),
        ("its leaves are green", None),
        ("green_is_its_leaves = 1\n", None),
    ],
)
def test_phrases_are_found_across_lines_and_literals(text, line):
    checked = prose(text) if text.endswith("\n") else text
    assert [(found, better) for found, _, better in hits(checked, RIDDLE)] == (
        [] if line is None else [(line, "its leaves are green")]
    )


def test_code_is_not_checked():
    assert hits(prose("green = is_ = its = leaves\n"), phrases("green  # of a colour\n")) == []


def test_a_phrase_without_a_better_wording_is_refused():
    with pytest.raises(AssertionError, match="green"):
        phrases("green is its leaves\n")
