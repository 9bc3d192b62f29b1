"""``nmap batch`` as a whole: good and bad files, tables, refusals, resuming, Ctrl-C and kill."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys

import pytest
from batch_cases import fill_with_maps, lines_of

import nmaptool as nm
from nmaptool.core.errors import ClusterError
from nmaptool.sets import cluster


@pytest.fixture
def folder(tmp_path, dome, codes, png, monkeypatch):
    """Good and bad maps in the folder ``maps`` of the current one."""
    monkeypatch.chdir(tmp_path)
    return fill_with_maps(tmp_path, dome, codes, png)


JOB = ("batch", "relief", "maps/*.png", "-o", "out/{stem}.stl", "--report", "out/{stem}.json", "--workers", "2")


def test_good_and_bad_files_changed_options_and_a_second_run(folder, run):
    done = run(*JOB, "--height", "4mm")
    lines = lines_of(done)
    assert done.code == 3
    assert len(lines) == 6
    status = {name: (line["status"], line["exit_code"]) for name, line in lines.items()}
    assert status == {f"good{n}.png": ("done", 0) for n in range(3)} | dict.fromkeys(
        ("bad.png", "grey.png", "empty.png"), ("failed", 3)
    )
    assert lines["good1.png"]["outputs"] == ["out/good1.stl", "out/good1.json"]
    assert set(lines["good1.png"]) == {
        *("inputs", "outputs", "exit_code", "status", "message", "warnings", "seconds", "recipe"),
    }
    assert "nmap batch: 6 items: 3 done, 3 failed\n" in done.err
    for name in ("bad.png", "grey.png", "empty.png"):
        single = run("relief", f"maps/{name}", "-o", "x.stl", "--height", "4mm")
        assert single.err == f"nmap: error: {lines[name]['message']}\n"
        assert f"nmap: error: {lines[name]['message']}\n" in done.err
    assert run("relief", "maps/good0.png", "-o", "x.stl", "--height", "4mm").code == 0
    assert (folder / "x.stl").read_bytes() == (folder / "out/good0.stl").read_bytes()

    for name in ("bad.png", "grey.png", "empty.png"):
        (folder / "maps" / name).unlink()
    again = run(*JOB, "--height", "4mm")
    assert again.code == 0
    assert {line["status"] for line in lines_of(again).values()} == {"skipped"}
    assert lines_of(again)["good1.png"]["outputs"] == lines["good1.png"]["outputs"]

    before = (folder / "out/good1.stl").read_bytes()
    (folder / "out/good2.stl").write_bytes(b"mine")
    other = run(*JOB, "--height", "5mm", "--json", "-v")
    lines = lines_of(other)
    assert [lines[f"good{n}.png"]["status"] for n in range(3)] == ["done", "done", "refused"]
    assert other.code == lines["good2.png"]["exit_code"] == 5
    assert "good2.stl: already exists; give another name, or --overwrite" in lines["good2.png"]["message"]
    assert (folder / "out/good1.stl").read_bytes() != before
    assert (folder / "out/good2.stl").read_bytes() == b"mine"
    assert lines["good1.png"]["report"]["options"]["height"] == "5mm"
    assert "maps/good1.png: wrote" in other.err.replace(os.sep, "/")
    assert [path.name for path in (folder / "out").glob(".*")] == [".nmap-batch.jsonl"]


def test_a_table_of_several_commands_with_quiet_messages(folder, run):
    (folder / "set").mkdir()
    (folder / "set/jobs.csv").write_text(
        "command,inputs,output,mode\n"
        "inspect,../maps/good0.png,,\n"
        "compose blend,../maps/good1.png;../maps/good2.png,x/{stem}.exr,rnm\n"
        "compose convert,../maps/good?.png,{stem}-{number}.exr,\n",
        encoding="utf-8",
    )
    refused = run("batch", "set/jobs.csv", "-q")
    assert (refused.code, refused.out) == (2, "")
    assert "set/jobs.csv, line 3: DETAIL is missing" in refused.err.replace(os.sep, "/")
    (folder / "set/jobs.csv").write_text(
        (folder / "set/jobs.csv")
        .read_text(encoding="utf-8")
        .replace("command,inputs", "command,inputs,inputs")
        .replace("good0.png,", "good0.png,,")
        .replace(";../maps", ",../maps")
        .replace("?.png,", "?.png,,"),
        encoding="utf-8",
    )
    done = run("batch", "set/jobs.csv", "-q")
    results = [json.loads(line) for line in done.out.splitlines()]
    assert done.err == ""
    assert {line["status"] for line in results} == {"done"}, results
    assert sorted(path.name for path in (folder / "set").rglob("*.exr")) == [
        *("good0-1.exr", "good1-2.exr", "good1.exr", "good2-3.exr"),
    ]
    assert done.code == max(line["exit_code"] for line in results)


def test_from_python_with_an_own_journal(folder):
    shares = []
    options = nm.BatchOptions(workers=1, journal=folder / "set.jsonl")
    jobs = [{"command": "inspect", "inputs": "maps/good*.png", "json": True}]
    results = list(nm.batch(jobs, options, progress=lambda text, share: shares.append((text, share))))
    assert [result.status for result in results] == ["done"] * 3
    assert [result.report["findings"] != [] for result in results] == [bool(result.exit_code) for result in results]
    assert shares[0] == ("0 of 3", 0)
    assert shares[-1] == ("3 of 3", 1)
    assert [result.status for result in nm.batch(jobs, options)] == ["skipped"] * 3
    codes = {result.exit_code for result in results}
    assert {result.exit_code for result in nm.batch(jobs, options)} == codes
    assert list(nm.batch([])) == []


def test_without_the_extra_one_line_says_what_to_install(folder, run, fails, monkeypatch):
    monkeypatch.setattr(cluster.importlib.util, "find_spec", lambda name: None)
    fails(run(*JOB), 2, r'sets of jobs need dask and distributed; install them with: pip install "nmaptool-relief\[cl')


@pytest.mark.parametrize(
    ("words", "code", "pattern"),
    [
        ((), 2, "COMMAND is missing"),
        (("relief", "none*.png", "-o", "a.stl"), 3, r"none\*\.png: no file fits this pattern"),
        (("relief", "maps/*.png", "-o", "a.stl"), 2, r"a\.stl: is the output of maps/bad\.png and of maps/empty\.png"),
        (("relief", "maps/*.png", "-o", "{stem}.stl", "--heigth", "3mm"), 2, "Unknown option: --heigth"),
        (("relief", "-", "-o", "a.stl"), 2, "-: a batch reads files"),
        (("jobs.toml",), 3, r"jobs\.toml: no such file"),
        (("jobs.toml", "--height", "3mm"), 2, "--height: a table of jobs holds all options; write it there"),
        (("relief", "maps/*.png", "-o", "{stem}.stl", "--workers", "0"), 2, "--workers 0: must lie between 1 and"),
        (("relief", "maps/*.png", "-o", "{stem}.stl", "--scheduler", "x"), 2, "--scheduler x: must be the address"),
    ],
)
def test_refused_before_any_work(words, code, pattern, folder, refused):
    refused(code, pattern, "batch", *words)


@pytest.mark.skipif(os.name == "nt", reason="Windows sends Ctrl-C to a whole console only")
@pytest.mark.parametrize("number", [signal.SIGINT, 9])
def test_a_batch_that_is_stopped_goes_on_to_the_same_bytes(number, folder, run):
    command = [sys.executable, "-c", "from nmaptool_cli.start import run\nrun()", *JOB, "--solver", "amg"]
    for name in ("bad.png", "grey.png", "empty.png"):
        (folder / "maps" / name).unlink()
    for copy in range(8):
        (folder / f"maps/more{copy}.png").write_bytes((folder / "maps/good0.png").read_bytes())
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True) as process:
        while b'"done"' not in process.stdout.readline():
            pass
        if number == signal.SIGINT:  # as a terminal does
            os.killpg(process.pid, number)
        else:
            process.kill()
        _, err = process.communicate(timeout=60)
    if number == signal.SIGINT:
        (line,) = err.decode().splitlines()
        assert process.returncode == 130
        assert line.startswith("nmap: error: interrupted; ")
        assert line.endswith(" of 11 items have ended; run the same command again to go on")
        assert {path.name for path in (folder / "out").glob(".*")} == {".nmap-batch.jsonl"}
    done = run(*JOB, "--solver", "amg")
    lines = lines_of(done)
    assert done.code == 0, done.err
    assert len(lines) == 11
    assert {line["status"] for line in lines.values()} == {"done", "skipped"}
    assert run("relief", "maps/good0.png", "-o", "x.stl", "--solver", "amg").code == 0
    for copy in range(8):
        assert (folder / f"out/more{copy}.stl").read_bytes() == (folder / "x.stl").read_bytes()


def test_a_process_that_imports_its_script_may_not_start_a_batch(folder, monkeypatch):
    monkeypatch.setattr(multiprocessing.current_process(), "_inheriting", True, raising=False)
    with pytest.raises(ClusterError, match=r'so the call belongs below if __name__ == "__main__":$'):
        nm.batch([{"command": "inspect", "inputs": "maps/good0.png"}])
