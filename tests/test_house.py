"""House rules: small files, light imports, one set of defaults, reproducible samples."""

import ast
import dataclasses
import inspect
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool import kernels
from nmaptool.core.errors import UsageError
from nmaptool_cli.compose.paste import PLACING
from nmaptool_cli.main import main
from nmaptool_cli.mentions import flag_of

ROOT = Path(__file__).parents[1]
SOURCES = [p for d in ("nmaptool", "cli", "bench", "samples", "tests") for p in sorted((ROOT / d).rglob("*.py"))]
HEAVY = {
    "cv2",
    "manifold3d",
    "matplotlib",
    "numpy",
    "OpenGL",
    "OpenImageIO",
    "PIL",
    "pyamg",
    "psd_tools",
    "pyrender",
    "scipy",
    "skimage",
    "svgelements",
    "tifffile",
    "trimesh",
    "uharfbuzz",
}


def too_large(path):
    """One line of text if the file has more than 300 lines, and one for each function of more than 60."""
    text, name = path.read_text(encoding="utf-8"), path.relative_to(ROOT)
    found = [f"{name} has {len(text.splitlines())} lines"] if len(text.splitlines()) > 300 else []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            body = node.body[1:] if ast.get_docstring(node) else node.body
            lines = body[-1].end_lineno - body[0].lineno + 1 if body else 0
            found += [f"{name}: {node.name} has {lines} lines"] if lines > 60 else []
    return found


@pytest.mark.house
def test_files_and_functions_are_small():
    assert len(SOURCES) > 400
    assert [line for path in SOURCES for line in too_large(path)] == []


def loaded_by(code):
    script = f"import sys\n{code}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_importing_the_package_loads_nothing_heavy():
    assert not loaded_by("import nmaptool; nmaptool.ReliefOptions(); nmaptool.length('3mm')") & HEAVY


def test_the_command_line_does_not_change_the_options_classes():
    code = """
import dataclasses, importlib, pkgutil
import nmaptool.options as options
from nmaptool.core.units import Length

def state():
    kinds = [kind for kind in vars(options).values() if isinstance(kind, type)] + [Length]
    return [(kind.__name__, dict(vars(kind)), dict(vars(kind).get("__annotations__", {}))) for kind in kinds]

before = state()
import nmaptool_cli
for module in pkgutil.walk_packages(nmaptool_cli.__path__, "nmaptool_cli."):
    importlib.import_module(module.name)
from nmaptool_cli.main import app, main
main(["relief", "--help"])
assert state() == before
"""
    loaded_by(code)


COMPOSE = ("blend", "convert", "depth", "pack", "paste", "split", "stack", "transform", "unpack")
COMMANDS = (
    "bake",
    "batch",
    "compare",
    "compose",
    *(f"compose {name}" for name in COMPOSE),
    "inspect",
    "preview",
    "relief",
    "smooth",
)


@pytest.mark.parametrize("arguments", ["--help", "--version", *(f"{command} --help" for command in COMMANDS)])
def test_help_loads_nothing_heavy(arguments):
    assert not loaded_by(f"from nmaptool_cli.main import main\nassert main({arguments.split()!r}) == 0") & HEAVY


# the twin of the compiled order of a graph is SciPy's
MULTIGRID = {"cv2", "OpenImageIO"} | (set() if kernels.IS_COMPILED else {"scipy.sparse"})
RUNS = {
    "relief MAP -o OUT.exr -q": MULTIGRID,
    "relief MAP -o OUT.npy -q --background-color none --solver dct": {"cv2", "OpenImageIO"},
    "relief MAP -o OUT.stl --preview OUT.png -q": MULTIGRID,
    "compose blend MAP MAP -o OUT.exr -q": {"cv2", "OpenImageIO"},
    "preview MAP -o OUT.png -q": MULTIGRID,
    "bake --help": set(),
    "inspect MAP -q": {"cv2", "OpenImageIO"},
}
WATCHED = HEAVY - {"numpy", "scipy"} | {
    "http.client",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.sparse",
    "scipy.spatial",
}


@pytest.mark.parametrize(("words", "needed"), RUNS.items())
def test_a_run_loads_only_the_heavy_modules_it_uses(words, needed, clean_map, tmp_path):
    words = words.replace("MAP", str(clean_map)).replace("OUT", str(tmp_path / "out"))
    script = f"import sys\nfrom nmaptool_cli.main import main\nassert main({words.split()!r}) == 0\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert set(done.stdout.splitlines()[-1].split()) & WATCHED == needed


@pytest.mark.parametrize("command", [c for c in COMMANDS if c != "compose"])
def test_help_of_a_command_has_an_example_and_lists_have_one_line(command, run, wide_help):
    assert f"Example: nmap {command} " in run(*command.split(), "--help").out
    for words in (["--help"], [*command.split()[:-1], "--help"]):
        shown = run(*words).out
        name = command.split()[len(words) - 1]
        (line,) = [line for line in shown.splitlines() if line.startswith(f"│ {name} ")]
        assert line.rstrip(" │").endswith(".")
        assert "Example" not in shown
    assert "()" not in run(*command.split(), "--help").out


def test_every_public_name_loads_and_has_a_docstring():
    for name in nm.__all__:
        value = getattr(nm, name)
        if name != "__version__":
            assert inspect.getdoc(value), name
    assert set(nm.__all__) - {"__version__"} == set(nm.__all__) - {"__version__"}
    # once imported, a module of the same name would replace the public name; nm.tiled is that module
    assert set(nm.__all__) & {path.stem for path in (ROOT / "nmaptool").iterdir()} == {"tiled"}
    assert all(inspect.getdoc(getattr(nm.tiled, name)) for name in nm.tiled.__all__)
    with pytest.raises(AttributeError, match="No nmaptool attribute carve"):
        _ = nm.carve


IO = (nm.ReadOptions, nm.WriteOptions)


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("relief", nm.ReliefOptions),
        ("preview", nm.PreviewOptions),
        ("relief", nm.ReadOptions),
        ("bake", nm.BakeOptions),
        ("bake", nm.FilterOptions),
        ("bake", nm.MeshReadOptions),
        *(
            (command, options)
            for command in ("smooth", "compare")
            for options in (nm.ReconstructOptions, nm.FilterOptions, nm.MeshReadOptions)
        ),
        ("smooth", nm.SmoothOptions),
        ("compare", nm.CompareOptions),
        ("compose split", nm.SplitOptions),
        ("compose blend", nm.BlendOptions),
        ("compose transform", nm.TransformOptions),
        *((f"compose {name}", options) for name in ("blend", "convert", "paste", "transform") for options in IO),
    ],
)
def test_every_option_is_a_documented_flag_with_the_librarys_default(command, options, capsys, wide_help):
    main([*command.split(), "--help"])
    shown = capsys.readouterr().out
    for field in dataclasses.fields(options):
        flag = flag_of(field.name)
        line = next(line for line in shown.splitlines() if line.startswith(f"│ {flag} "))
        assert f"\n{field.name}:" in inspect.getdoc(options)  # Python 3.13 strips the indent itself
        if field.default is not None and field.type != "bool":
            assert f"[default: {field.default}]" in line


def test_every_layer_option_is_a_flag_of_paste_with_its_default(capsys, wide_help):
    main(["compose", "paste", "--help"])
    shown = capsys.readouterr().out.splitlines()
    defaults = {field.name: field.default for field in dataclasses.fields(nm.LayerOptions)}
    # a pasted layer is named after its file
    assert set(PLACING.names) == set(defaults) - {"name"}
    for name in set(defaults) - {"name"}:
        (line,) = (line for line in shown if line.startswith(f"│ --{name.replace('_', '-')} "))
        if defaults[name]:  # otherwise help need not show it
            assert f"[default: {defaults[name]}]" in line
    words = {name: False if isinstance(defaults[name], bool) else () for name in PLACING.names}
    assert PLACING.spread(words, 2) == [nm.LayerOptions()] * 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mu": -1.0}, "`mu=-1`: must be zero or more"),
        ({"beta": float("nan")}, "`beta=nan`: must be zero or more"),
        ({"delta": float("inf")}, "`delta=inf`: must be a number"),
        ({"slope_cap": 0.0}, "`slope_cap=0`: must be greater than zero"),
        ({"tolerance": 0.0}, "`tolerance=0`: must lie between 1e-14 and 1"),
        ({"max_iterations": 0}, "`max_iterations=0`: must be at least 1"),
        ({"width": nm.length("3%")}, "`width='3%'`: .* give it in mm, cm, m or in"),
        ({"fit": "delta"}, "`fit='delta'`: needs `height`"),
        ({"background": "wall"}, "`background='wall'`: use one of plane, free, cut, surface"),
        ({"energy": "eq5"}, "`energy='eq5'`: use one of eq6, eq4"),
        ({"solver": "lu"}, "`solver='lu'`: use one of auto, dct, multigrid, amg"),
    ],
)
def test_invalid_relief_options_are_refused(changes, message):
    with pytest.raises(UsageError, match=message):
        nm.ReliefOptions(**changes)


def test_invalid_read_options_are_refused():
    for color in ("pink", "#12345", "#gggggg"):
        with pytest.raises(UsageError, match=r"`background_color=.*`: use one of auto, none, alpha"):
            nm.ReadOptions(background_color=color)
    with pytest.raises(UsageError, match="`max_megapixels=0`: must be greater than zero"):
        nm.ReadOptions(max_megapixels=0)


@pytest.mark.parametrize("text", ["", "3", "mm", "-3mm", "0mm", "3 km", "nan mm", "1e400mm", "3mm4"])
def test_invalid_lengths_are_refused(text):
    with pytest.raises(UsageError, match=r"expected a number with a unit|must be greater than zero"):
        nm.length(text)


def test_lengths_are_read_in_every_unit():
    in_mm = {"12mm": 12, "1.2cm": 12, "0.5 in": 12.7, "4px": 2, "3%": 15, "1e1MM": 10}
    for text, expected in in_mm.items():
        assert nm.length(text).to_mm(pitch_mm=0.5, longer_side_px=1000) == pytest.approx(expected)


def test_samples_are_small_and_made_by_their_script(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["make_samples.py", str(tmp_path)])
    runpy.run_path(str(ROOT / "samples" / "make_samples.py"), run_name="__main__")
    shipped = sorted(p.name for p in (ROOT / "samples").glob("*.png"))
    assert shipped == sorted(p.name for p in tmp_path.iterdir())
    assert sum((ROOT / "samples" / name).stat().st_size for name in shipped) < 1_000_000
    for name in shipped:
        made, kept = (nm.read_raster(folder / name).pixels for folder in (tmp_path, ROOT / "samples"))
        # sines may differ in their last bit between machines
        assert abs(made.astype(int) - kept.astype(int)).max() <= 1, name


def test_sample_layers_belong_to_one_original():
    options = nm.ReadOptions()
    original, base, detail = (
        nm.read_normal_map(ROOT / "samples" / f"medal_{layer}.png", options) for layer in ("original", "base", "detail")
    )
    t = base.normals + np.array([0, 0, 1])
    u = detail.normals * (-1, -1, 1)
    blended = t * (t * u).sum(axis=-1, keepdims=True) / t[..., 2:] - u
    angle = (blended * original.normals).sum(axis=-1).clip(-1, 1)
    assert angle[original.foreground].min() > 0.99999  # reoriented blending of base and detail reproduces the original
