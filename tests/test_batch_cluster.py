"""Workers of a batch that die, and clusters that run elsewhere, go away or do not answer."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import cloudpickle
import psutil
import pytest
from batch_cases import fill_with_maps, lines_of

import nmaptool as nm
from nmaptool.core.errors import ClusterError
from nmaptool.sets import cluster
from nmaptool.sets import dispatch as dispatch_module
from nmaptool.sets import worker as in_worker
from nmaptool.sets.cluster import local_client
from nmaptool.sets.dispatch import Dispatch
from nmaptool.types.batch import BatchItem

# workers cannot import this module
cloudpickle.register_pickle_by_value(sys.modules[__name__])


@pytest.fixture
def folder(tmp_path, dome, codes, png, monkeypatch):
    """Good and bad maps in the folder ``maps`` of the current one."""
    monkeypatch.chdir(tmp_path)
    return fill_with_maps(tmp_path, dome, codes, png)


def kill_some(item, threads, begun):
    """A task that ends its process for some items: always, once, or never."""
    first = not Path(begun).with_name(Path(begun).name.replace("-2", "-1")).exists() or begun.endswith("-1")
    Path(begun).touch()
    if item.command == "kill" or (item.command == "kill once" and first):
        os.kill(os.getpid(), signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
    time.sleep(0.02)
    return nm.BatchResult(item.inputs, item.outputs, 0, "done")


def fail_to_run(item, threads, begun):
    raise ValueError("no such thing\nand more")


def test_a_process_that_dies_is_tried_once_more_and_the_others_go_on(tmp_path):
    names = ["kill", "kill once", *["work"] * 8]
    items = [BatchItem(name, (), {}, (f"{number}.png",), (), (), "", ".") for number, name in enumerate(names)]
    (tmp_path / "spool").mkdir()
    sent = []

    def begin(number):
        sent.append(number)
        return items[number]

    with local_client(2, 1, str(tmp_path)) as client:
        with Dispatch(client, items, begin, 1, tmp_path / "spool", task=kill_some) as dispatch:
            found = dict(dispatch.results(range(10)))
        with Dispatch(client, items, begin, 1, tmp_path / "spool", task=fail_to_run) as dispatch:
            ((_, failed),) = dispatch.results([5])
    assert found[0].message == (
        "0.png: its process ended twice in the middle (killed, or out of memory); use fewer `workers` or a smaller map"
    )
    assert (found[0].status, found[0].exit_code) == ("failed", 8)
    assert {found[number].status for number in range(1, 10)} == {"done"}
    assert sent.count(1) >= 2
    assert (failed.status, failed.message) == ("failed", "5.png: the worker cannot run it (no such thing)")


def test_a_killed_process_costs_no_item(folder):
    """Kill the process of a real item as soon as it is sent; all items end."""
    jobs = [{"command": "relief", "inputs": "maps/good*.png", "output": "out/{stem}.stl", "solver": "amg"}]
    journal, killed, ended = folder / "set.jsonl", [], threading.Event()

    def kill():
        while not (killed or ended.is_set()):
            time.sleep(0.005)
            if journal.exists() and b"begun" in journal.read_bytes():
                with contextlib.suppress(psutil.Error):
                    (worker,) = (c for c in psutil.Process().children() if "spawn_main" in " ".join(c.cmdline()))
                    worker.kill()
                    killed.append(worker.pid)

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        results = list(nm.batch(jobs, nm.BatchOptions(workers=1, journal=journal)))
    finally:
        ended.set()
        thread.join()
    assert len(killed) == 1
    assert [result.status for result in results] == ["done"] * 3, results
    assert {path.name for path in (folder / "out").glob("*.stl")} == {f"good{n}.stl" for n in range(3)}


def test_a_cluster_that_has_lost_its_workers(tmp_path, monkeypatch):
    class Client:
        status = "running"

        def nthreads(self):
            return {}

    monkeypatch.setattr(dispatch_module, "_ALONE_S", 0.3)
    waiting = Dispatch(Client(), [], lambda number: None, 1, tmp_path)
    with pytest.raises(ClusterError, match=r"^there has been no worker for 0 s; run the same command again to go on"):
        waiting._next()
    Client.status = "closed"
    with pytest.raises(ClusterError, match=r"^the scheduler has gone; "):
        waiting._next()


SCHEDULER = """
import sys, time
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=1, threads_per_worker=2, processes=True, dashboard_address="127.0.0.1:0") as cluster:
        print(cluster.scheduler_address, flush=True)
        time.sleep(120)
"""


@pytest.fixture
def scheduler(tmp_path):
    """The process of a cluster, and its address."""
    script = tmp_path / "cluster.py"
    script.write_text(SCHEDULER, encoding="utf-8")
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process, process.stdout.readline().strip()
        finally:
            process.kill()


def test_a_running_cluster_and_its_end(folder, run, scheduler):
    process, address = scheduler
    done = run("batch", "relief", "maps/good*.png", "-o", "out/{stem}.stl", "--scheduler", address)
    assert (done.code, [line["status"] for line in lines_of(done).values()]) == (0, ["done"] * 3), done.err
    results = nm.batch(
        [{"command": "relief", "inputs": "maps/good*.png", "output": "out/{stem}.ply"}],
        nm.BatchOptions(scheduler=address),
    )
    next(results)
    process.kill()
    with pytest.raises(
        ClusterError, match=r"^the scheduler has gone; run the same command again to go on with the other"
    ):
        list(results)


def test_a_cluster_that_does_not_answer_or_has_another_version(folder, run, fails, monkeypatch):
    monkeypatch.setattr(cluster, "_CONNECT_S", 0.2)
    words = ("batch", "inspect", "maps/good*.png", "--scheduler", "tcp://127.0.0.1:9")
    fails(run(*words), 8, r"tcp://127\.0\.0\.1:9: no scheduler answers \(.*\); start one with: dask scheduler")

    class Client:
        def run(self, function):
            return {"tcp://10.0.0.7:1": "0.0.7"}

    with pytest.raises(
        ClusterError, match=r"^tcp://10\.0\.0\.7:1: has nmaptool 0\.0\.7, and this is .*; install the same"
    ):
        cluster._check_versions(Client(), "tcp://a:1")
    Client.run = lambda self, function: (_ for _ in ()).throw(ModuleNotFoundError("No module named 'nmaptool'"))
    with pytest.raises(
        ClusterError, match=r"^tcp://a:1: a worker cannot load nmaptool \(No module named 'nmaptool'\); "
    ):
        cluster._check_versions(Client(), "tcp://a:1")
    assert in_worker.version() == nm.__version__
