"""Work in threads: ordered results, errors, nested calls, forks and the end of the program."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest

from nmaptool.core import parallel as bands
from nmaptool.core.parallel import for_each_band, map_parallel


@pytest.fixture
def four_cores(monkeypatch):
    monkeypatch.setattr(bands, "cores", lambda: 4)
    monkeypatch.setattr(bands._kept, "_pool", None)


def meet(count):
    """A task that ends only if ``count`` of them run at the same time."""
    gate = threading.Barrier(count, timeout=10)
    return lambda _: gate.wait() >= 0


@pytest.mark.usefixtures("four_cores")
def test_tasks_run_in_parallel_and_results_keep_their_order():
    assert map_parallel(range(4), meet(4)) == [True] * 4
    assert map_parallel(range(100), lambda n: n * n) == [n * n for n in range(100)]
    assert map_parallel([], meet(2)) == []


def test_bands_cover_every_row_exactly_once():
    seen = np.zeros(103, int)

    def count(band):
        seen[band] += 1

    for_each_band(103, 10, count)
    assert (seen == 1).all()


@pytest.mark.usefixtures("four_cores")
def test_threads_are_reused():
    names = {thread for _ in range(5) for thread in map_parallel(range(4), lambda _: threading.get_ident())}
    assert len(names) <= 4


@pytest.mark.usefixtures("four_cores")
def test_nested_calls_run_in_the_calling_thread():
    def inner(_):
        return threading.get_ident()

    for outer in map_parallel(range(8), lambda n: (threading.get_ident(), map_parallel(range(8), inner))):
        assert set(outer[1]) == {outer[0]}
    # afterwards, the caller can share its work again
    assert map_parallel(range(4), meet(4)) == [True] * 4


@pytest.mark.usefixtures("four_cores")
def test_the_first_error_is_raised_and_no_task_continues():
    started, ended = [], []

    def work(number):
        started.append(number)
        time.sleep(0.02)
        ended.append(number)
        if number in (2, 3):
            raise ValueError(f"task {number}")

    with pytest.raises(ValueError, match="task 2"):
        map_parallel(range(1000), work)
    assert sorted(started) == sorted(ended)
    assert len(started) < 1000
    assert map_parallel(range(4), meet(4)) == [True] * 4


@pytest.mark.usefixtures("four_cores")
def test_several_threads_may_call_at_once():
    results = []

    def call(start):
        results.append(map_parallel(range(start, start + 50), lambda n: n + 1) == list(range(start + 1, start + 51)))

    threads = [threading.Thread(target=call, args=(start,)) for start in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)
    assert results == [True] * 10


@pytest.mark.usefixtures("four_cores")
@pytest.mark.skipif(int(np.__version__.partition(".")[0]) < 2, reason="NumPy 1 keeps its error state per thread")
def test_every_thread_has_the_callers_error_state():
    gate = threading.Barrier(4, timeout=10)

    def state(_):
        gate.wait()
        return np.geterr()["over"]

    with np.errstate(over="raise"):
        assert map_parallel(range(4), state) == ["raise"] * 4


@pytest.mark.usefixtures("four_cores")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_creates_its_own_threads():
    map_parallel(range(4), meet(4))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12 warns about forks in a threaded process
        child = os.fork()
    if child == 0:
        signal.alarm(10)
        os._exit(0 if map_parallel(range(4), meet(4)) == [True] * 4 else 1)
    assert os.waitpid(child, 0)[1] == 0


PROGRAM = """
import os, signal, sys, threading, time
from nmaptool.core import parallel as bands
bands.cores = lambda: 4
bands.map_parallel(range(4), lambda _: time.sleep(0.01))
if sys.argv[1] == "end":
    import atexit
    atexit.register(lambda: print(bands.map_parallel(range(4), abs)))
else:
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        bands.map_parallel(range(10_000), lambda _: time.sleep(0.01))
    except KeyboardInterrupt:
        print("stopped")
"""


@pytest.mark.parametrize(("how", "stated"), [("end", "[0, 1, 2, 3]"), ("interrupt", "stopped")])
def test_threads_do_not_delay_the_end_or_ctrl_c(how, stated):
    if how == "interrupt" and sys.platform == "win32":
        pytest.skip("Ctrl-C cannot be sent to one process")
    done = subprocess.run([sys.executable, "-c", PROGRAM, how], capture_output=True, text=True, timeout=20, check=True)
    assert done.stdout.strip() == stated
    assert not done.stderr
