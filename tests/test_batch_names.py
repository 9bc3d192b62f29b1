"""Patterns and placeholders of a batch, and the items that they make."""

from pathlib import Path

import pytest

from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.sets.patterns import expand, fill, has_placeholder
from nmaptool_cli.sets.items import items_of, job_of_words, ready
from nmaptool_cli.sets.parsed import command_names, takes_several


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of empty files, which is also the current folder."""
    for name in (
        "maps/b.png",
        "maps/a.png",
        "maps/c.exr",
        "maps/deep/a.png",
        "maps/.hidden.png",
        "odd[1].png",
        "maps/store.zarr/a",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "maps/folder.png").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def items(*words):
    return items_of([job_of_words([str(word) for word in words])])


@pytest.mark.parametrize(
    ("patterns", "found"),
    [
        (["maps/*.png"], ["maps/a.png", "maps/b.png"]),
        (["maps/b.png", "maps/*.*"], ["maps/b.png", "maps/a.png", "maps/c.exr", "maps/store.zarr"]),
        (["maps/**/a.png"], ["maps/a.png", "maps/deep/a.png"]),
        (["maps/[bc].*"], ["maps/b.png", "maps/c.exr"]),
        (["maps/*.exr:detail"], ["maps/c.exr:detail"]),
        (["odd[1].png", "missing.png"], ["odd[1].png", "missing.png"]),
        (["maps/*.zarr"], ["maps/store.zarr"]),
    ],
)
def test_patterns_are_expanded_in_order_and_once(folder, patterns, found):
    assert expand(patterns, folder) == found


def test_a_pattern_without_files_is_refused(folder):
    with pytest.raises(InputError, match=r"^maps/\*\.tif: no file fits this pattern$"):
        expand(["maps/*.tif"], folder)


@pytest.mark.parametrize(
    ("text", "filled"),
    [
        ("{stem}", "a.b"),
        ("out/{parent}/{name}.json", "out/lions/a.b.png.json"),
        ("{number}-{number:3}-{number:03}", "7-007-007"),
        ("{{{stem}}} }}", "{a.b} }"),
        ("{stem}_{row}_{col}.stl", "a.b_{row}_{col}.stl"),
        ("plain", "plain"),
    ],
)
def test_placeholders(text, filled):
    assert fill(text, "maps/lions/a.b.png", 7) == filled
    assert has_placeholder(text) == (text != "plain")


def test_placeholders_of_a_layer_and_of_a_file_without_a_folder():
    assert fill("{parent}/{stem}", "a.exr:detail", 1) == "./a"


def test_an_unknown_placeholder_is_refused():
    with pytest.raises(
        UsageError, match=r"^\{stme\}\.stl: the placeholder \{stme\} is unknown; use \{stem\}, \{name\}"
    ):
        fill("{stme}.stl", "a.png", 1)


def test_every_input_becomes_an_item_with_its_own_files(folder):
    found = items(
        "relief", "maps/*.png", "-o", "{stem}.stl", "--mask={stem}-mask.png", "--delta", "-3", "-o", "{number}.exr"
    )
    assert [item.inputs for item in found] == [("maps/a.png",), ("maps/b.png",)]
    assert found[1].arguments == ("maps/b.png",)
    assert found[1].flags == {"output": (Path("b.stl"), Path("2.exr")), "mask": "b-mask.png", "delta": -3}
    assert found[1].outputs == ("b.stl", "2.exr")
    assert found[1].folder == str(folder)


def test_a_second_input_may_have_placeholders_or_stay(folder):
    (with_names,) = items("compose", "blend", "maps/b.png", "maps/deep/{stem}.png", "-o", "x.exr")
    assert with_names.arguments == ("maps/b.png", "maps/deep/b.png")
    same = items("compose", "blend", "maps/*.png", "maps/c.exr", "-o", "{stem}.exr")
    assert [item.arguments[1] for item in same] == ["maps/c.exr"] * 2
    assert str(folder / "maps/c.exr") in {str(folder / name) for name in same[0].files}
    (converted,) = items("compose", "convert", "maps/c.exr", "{stem}.png")
    assert converted.outputs == ("c.png",)
    assert [name for name in command_names() if takes_several(name)] == ["compose blend", "compose paste"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "COMMAND is missing; name one, such as nmap batch relief"),
        ("--height 4mm", "COMMAND is missing"),
        ("carve maps/*.png", r"carve: is not a command for a batch; use inspect, bake, .*compose convert"),
        ("studio maps/*.png", "studio: is not a command for a batch"),
        ("batch relief", "batch: is not a command for a batch"),
        ("compose maps/*.png", r"compose maps/\*\.png: is not a command for a batch"),
        ("relief -o a.stl", r"no input given: name one or more, such as 'maps/\*\.png'"),
        ("relief {stem}.png -o a.stl", r"\{stem\}\.png: an input may have \* and \?, but placeholders are for outputs"),
        ("relief - -o a.stl", "-: a batch reads files, so that it can go on where it stopped"),
        ("compose convert maps/*.png -o -", "-: the items of a batch write files"),
        ("relief maps/*.png -o a.stl", r"a\.stl: is the output of maps/a\.png and of maps/b\.png; use \{stem\}"),
        (
            "relief maps/*.png -o {stem}.stl --report r.json",
            r"r\.json: is the output of maps/a\.png and of maps/b\.png",
        ),
        ("relief maps/*.png -o {foo}.stl", r"\{foo\}\.stl: the placeholder \{foo\} is unknown"),
        ("relief maps/a.png -o a.stl --heigth 4mm", r"Unknown option: --heigth.* \(see nmap relief --help\)"),
        ("relief maps/a.png -o a.stl --height 4", r"`height='4'`: expected a number with a unit"),
        ("relief maps/a.png -o a.stl --max-iterations 3.5", "--max-iterations '3.5': must be a whole number"),
        ("compose transform maps/a.png -o a.exr --crop 3", "`crop='3'`"),
    ],
)
def test_a_job_that_is_not_accepted_is_refused_before_the_work(folder, words, message):
    with pytest.raises(UsageError, match=f"^{message}"):
        items(*words.split())


def test_an_output_that_is_another_input_is_refused(folder):
    with pytest.raises(InputError, match=r"^maps/b\.png: is an input and also an output of maps/a\.png; write outputs"):
        items_of([job_of_words(["relief", "maps/a.png", "-o", "maps/b.png"]), job_of_words(["inspect", "maps/b.png"])])


def test_the_recipe_changes_with_options_and_inputs_only(folder):
    def recipe(*words):
        (item,) = items("relief", "maps/a.png", "-o", "a.stl", *words)
        return item.recipe

    plain = recipe("--height", "4mm", "--mu=0.2")
    assert recipe("--mu", "0.2", "--height=4mm") == plain
    assert recipe("--height", "4mm", "--mu=0.2", "-v", "--overwrite", "--memory-limit", "1GB") == plain
    assert recipe("--height", "5mm", "--mu=0.2") != plain
    (folder / "mask.png").touch()
    masked = recipe("--mask", "mask.png")
    (folder / "mask.png").write_bytes(b"1")
    assert recipe("--mask", "mask.png") != masked
    (folder / "maps/a.png").write_bytes(b"1")
    assert recipe("--height", "4mm", "--mu=0.2") != plain
    (store,) = items("relief", "maps/store.zarr", "-o", "a.zarr")
    assert store.files == ("maps/store.zarr",)
    (folder / "maps/store.zarr/a").write_bytes(b"1")
    assert items("relief", "maps/store.zarr", "-o", "a.zarr")[0].recipe != store.recipe


def test_the_files_that_a_recipe_names_are_inputs(folder):
    (folder / "maps/scene.toml").write_text(
        '[[layer]]\nfile = "a.png"\n[[layer]]\nrecipe = "in.toml"\n', encoding="utf-8"
    )
    (folder / "maps/in.toml").write_text('[[layer]]\nfile = "b.png"\n', encoding="utf-8")
    (item,) = items("relief", "maps/scene.toml", "-o", "a.stl")
    assert item.files[0] == "maps/scene.toml"
    assert set(item.files[1:]) == {"maps/a.png", "maps/in.toml", "maps/b.png"}
    (folder / "maps/scene.toml").write_text("[[", encoding="utf-8")
    assert items("relief", "maps/scene.toml", "-o", "a.stl")[0].files == ("maps/scene.toml",)


def test_the_batch_adds_leave_to_replace_and_the_limit_of_memory(folder):
    (item,) = items("relief", "maps/a.png", "-o", "a.stl")
    more = ready(item, overwrite=True, memory_limit="1GB").flags
    assert more == {**item.flags, "overwrite": True, "memory_limit": "1GB"}
    assert ready(item, overwrite=False, memory_limit=None) == item
    (item,) = items("inspect", "maps/a.png")
    assert ready(item, overwrite=True, memory_limit="1GB") == item
    (item,) = items("relief", "maps/a.png", "-o", "a.stl", "--overwrite", "--memory-limit", "2GB")
    assert ready(item, overwrite=True, memory_limit="1GB") == item
    (item,) = items("relief", "maps/a.png", "-o", "{stem}_{row}_{col}.stl", "--parts", "2x2")
    assert ready(item, overwrite=True, memory_limit=None) == item
