"""Ctrl-C at every stage: one line, exit code 130, no file; and the progress bar of a real terminal."""

import os
import subprocess
import sys
import textwrap

import pytest

LINE = "nmap: error: interrupted; nothing was written\n"
# a process that sends itself SIGINT where the inserted patch calls stop()
SCRIPT = """
import signal, sys
from nmaptool_cli import main, run

def stop():
    signal.raise_signal(signal.SIGINT)

{patch}
sys.argv = ["nmap", *sys.argv[1:]]
main.run()
"""
AT = {
    "reading": """
        from nmaptool.io.pictures import reader as images
        read = images.read_image
        images.read_image = lambda *a, **k: (stop(), read(*a, **k))[1]
        """,
    "setup": """
        from nmaptool.reliefs import session as relief_session
        prepare = relief_session.prepare
        relief_session.prepare = lambda *a, **k: (stop(), prepare(*a, **k))[1]
        """,
    "solve": """
        import contextlib
        def progress(word, share):
            if word == "solving":
                stop()
        run.Run.progress = lambda self: contextlib.nullcontext(progress)
        """,
    "writing": """
        from nmaptool.io.pictures import heights
        write = heights.write_height
        heights.write_height = lambda *a, **k: (write(*a, **k), stop())[0]
        """,
    "preview": """
        from nmaptool.figures import preview
        preview.preview = lambda height: stop()
        """,
}
# a call of several minutes that Python cannot interrupt, with Ctrl-C at its start
DEAF = """
        import hashlib, threading
        def deaf(*a, **k):
            threading.Timer(0.2, stop).start()
            hashlib.pbkdf2_hmac("sha256", b"", b"", 1_000_000_000)
        """
DEAF_AT = {
    "reading": "from nmaptool.io.pictures import reader as images\nimages.read_image = deaf",
    "writing": """from nmaptool.io.pictures import heights
write = heights.write_height
heights.write_height = lambda *a, **k: (write(*a, **k), deaf())[0]""",
}


def command(patch, *words):
    return [sys.executable, "-c", SCRIPT.format(patch=textwrap.dedent(patch)), *map(str, words)]


def words_for(clean_map, tmp_path):
    return (
        "relief",
        "-q",
        clean_map,
        "-o",
        tmp_path / "a.exr",
        "-o",
        tmp_path / "a.stl",
        "--preview",
        tmp_path / "a.png",
    )


def run_script(patch, *words):
    return subprocess.run(command(patch, *words), capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("stage", AT)
def test_ctrl_c_prints_one_line_and_leaves_no_file(stage, clean_map, tmp_path, tree):
    before = tree()
    done = run_script(AT[stage], *words_for(clean_map, tmp_path))
    assert (done.returncode, done.stderr, done.stdout) == (130, LINE, "")
    assert tree() == before


@pytest.mark.parametrize("stage", DEAF_AT)
def test_ctrl_c_ends_an_uninterruptible_call(stage, clean_map, tmp_path, tree):
    before = tree()
    done = run_script(textwrap.dedent(DEAF) + DEAF_AT[stage], *words_for(clean_map, tmp_path))
    assert (done.returncode, done.stderr, done.stdout) == (130, LINE, "")
    assert tree() == before


@pytest.mark.parametrize("error", ["ValueError('half of it')", "errors.RendererError('no OpenGL context')"])
def test_ctrl_c_works_even_if_a_library_replaces_the_exception(error, clean_map, tmp_path, tree):
    before = tree()
    patch = f"""
        from nmaptool.core import errors
        from nmaptool.io.pictures import reader as images
        def read(*a, **k):
            try:
                stop()
            except KeyboardInterrupt:
                raise {error}
        images.read_image = read
        """
    done = run_script(patch, *words_for(clean_map, tmp_path))
    assert (done.returncode, done.stderr, done.stdout) == (130, LINE, "")
    assert tree() == before


def test_ctrl_c_is_ignored_if_the_shell_ignores_it(clean_map, tmp_path):
    ignored = "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    done = run_script(ignored + textwrap.dedent(AT["writing"]), *words_for(clean_map, tmp_path))
    assert (done.returncode, done.stderr) == (0, "")


def test_ctrl_c_leaves_no_new_folder(clean_map, tmp_path, tree):
    before = tree()
    patch = (
        DEAF
        + """
        from nmaptool.io.output import layers as layer_files
        layer_files.write_pictures = deaf
        """
    )
    done = run_script(textwrap.dedent(patch), "compose", "split", clean_map, "-o", tmp_path / "layers", "-q")
    assert (done.returncode, done.stderr, done.stdout) == (130, LINE, "")
    assert tree() == before


def test_ctrl_c_keeps_the_file_to_be_replaced(clean_map, tmp_path):
    old = tmp_path / "a.exr"
    old.write_text("old", encoding="utf-8")
    done = run_script(AT["writing"], "relief", clean_map, "-o", old, "--overwrite")
    assert done.returncode == 130
    assert old.read_text(encoding="utf-8") == "old"


def test_ctrl_c_while_commands_load_prints_one_line():
    code = """
        import signal, sys
        class Finder:
            def find_spec(self, name, *_):
                if name == "cyclopts":
                    signal.raise_signal(signal.SIGINT)
        sys.meta_path.insert(0, Finder())
        from nmaptool_cli.start import run
        run()
        """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (130, LINE)


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs a terminal")
@pytest.mark.parametrize(("after", "words", "shown"), [("0", (), True), ("1e6", (), False), ("0", ("-q",), False)])
def test_a_terminal_shows_the_progress_of_a_long_solve(after, words, shown, clean_map, tmp_path):
    """The bar appears only after a delay; here at once or never, and each step waits until it is drawn."""
    patch = f"""
        from nmaptool_cli import late_bar
        late_bar._AFTER_S = {after}
        if {shown}:
            report = late_bar.LateBar.report
            def slowly(self, word, share):
                self._timer.join()
                report(self, word, share)
                self._bar.refresh()
            late_bar.LateBar.report = slowly
        """
    ours, theirs = os.openpty()
    words = ("relief", clean_map, "--solver", "amg", "-o", tmp_path / "a.exr", *words)
    env = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    with subprocess.Popen(command(patch, *words), stderr=theirs, stdout=subprocess.DEVNULL, env=env) as process:
        os.close(theirs)
        seen = b""
        while True:
            try:
                piece = os.read(ours, 1 << 16)
            except OSError:  # the end of a terminal's output
                break
            if not piece:
                break
            seen += piece
    os.close(ours)
    assert process.returncode == 0
    assert (b"setting up" in seen, b"solving" in seen) == (shown, shown)
    assert (b"unknowns" in seen) == ("-q" not in words)
