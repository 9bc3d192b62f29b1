"""Tables: an added entry appears in flags, help, recipes and messages, and the README check reports it missing."""

import numpy as np
import pytest
from compose_cases import bump_map

import nmaptool as nm
from docs import readme_tables
from nmaptool.core.errors import InputError, UsageError
from nmaptool.options import BlendMode
from nmaptool.options.formats import MapFormat

README = readme_tables.README.read_text(encoding="utf-8")


def test_the_lists_in_the_readme_match_the_tables():
    assert readme_tables.stale(README) == []
    assert readme_tables.filled(README) == README


@pytest.fixture
def darker(monkeypatch):
    """A blend mode that picks the steeper of two normals."""

    def kernel(base, detail, result, work):
        steeper = detail[2] < base[2]
        for axis in range(3):
            result[axis][...] = np.where(steeper, detail[axis], base[axis])

    mode = BlendMode("takes the steeper normal", kernel, flat_base=False)
    monkeypatch.setitem(nm.BLEND_MODES, "steeper", mode)
    return mode


def test_a_blend_mode_added_at_run_time_blends(darker, tmp_path, run):
    base, detail = bump_map(20, 30), bump_map(20, 30, height=-2.0)
    result = nm.blend(base, detail, nm.BlendOptions(mode="steeper")).normal_map
    steeper = np.where((detail.normals[..., 2] < base.normals[..., 2])[..., None], detail.normals, base.normals)
    assert np.abs(result.normals - steeper).max() < 1e-6
    for name, one in (("base", base), ("detail", detail)):
        nm.write_normal_map(one, tmp_path / f"{name}.exr")
    files = (tmp_path / "base.exr", tmp_path / "detail.exr")
    assert run("compose", "blend", *files, "--mode", "steeper", "-o", tmp_path / "out.exr").code == 0
    assert np.abs(nm.read_normal_map(tmp_path / "out.exr").normals - steeper).max() < 1e-6
    assert run("compose", "paste", *files, "--mode", "steeper", "-o", tmp_path / "pasted.exr").code == 0


def test_a_blend_mode_added_at_run_time_is_offered(darker, run, wide_help):
    for command in ("blend", "paste", "pack"):
        assert "steeper" in run("compose", command, "--help").out, command
    assert '"steeper" takes the steeper normal.' in run("compose", "blend", "--help").out
    with pytest.raises(UsageError, match=r"`mode='screen'`: use one of rnm, .*, overlay, steeper$"):
        nm.BlendOptions(mode="screen")
    with pytest.raises(UsageError, match=r"`mode='screen'`: use one of over, rnm, .*, steeper$"):
        nm.LayerOptions(mode="screen")
    assert '"overlay", "steeper"' in run("compose", "blend", "a.exr", "b.exr", "--mode", "screen", "-o", "c.exr").err
    entry = {"file": "a.png", "mode": "steeper"}
    assert nm.parse_recipe({"layer": [entry]}).layers[0].options.mode == "steeper"
    with pytest.raises(InputError, match=r"mode = \"screen\": use one of over, .*, steeper$"):
        nm.parse_recipe({"layer": [{**entry, "mode": "screen"}]})
    assert readme_tables.stale(README) == ["blend modes"]
    assert "| `steeper` | takes the steeper normal |" in readme_tables.filled(README)


def test_a_removed_mode_is_refused_again(run):
    with pytest.raises(UsageError, match=r"`mode='steeper'`: use one of rnm"):
        nm.BlendOptions(mode="steeper")
    assert "steeper normal" not in run("compose", "blend", "--help").out


def test_a_map_format_added_at_run_time_is_offered(run, wide_help, monkeypatch, tmp_path):
    entry = MapFormat(
        "numbers as text", lambda normal_map, path, *_: path.write_text("ours", encoding="utf-8"), bits=("8",)
    )
    monkeypatch.setitem(nm.NORMAL_MAP_FORMATS, ".txt", entry)
    for command in ("blend", "paste", "stack", "transform", "convert", "depth"):
        assert ".txt numbers as text" in run("compose", command, "--help").out, command
    nm.write_normal_map(bump_map(20, 30), tmp_path / "a.exr")
    done = run("compose", "transform", tmp_path / "a.exr", "-o", tmp_path / "b.jpg")
    assert (done.code, done.err.rstrip().endswith("written as .png, .exr, .tif, .tiff, .txt")) == (2, True)
    assert run("compose", "transform", tmp_path / "a.exr", "-o", tmp_path / "b.txt").code == 0
    assert (tmp_path / "b.txt").read_text(encoding="utf-8") == "ours"
    assert readme_tables.stale(README) == ["normal maps"]


def test_an_unknown_list_name_is_refused():
    with pytest.raises(KeyError, match="colours"):
        readme_tables.filled("<!-- list: colours -->\n<!-- end of list -->")
