"""Processes of this machine and a Dask cluster give what one process gives."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from rcc_sim.batch import engine
from rcc_sim.batch.batch import run_batch
from rcc_sim.batch.engine import Engine
from rcc_sim.errors import InputError, RccError
from rcc_sim.processes import ONE_THREAD, _unheard
from tests.batch.test_store import Squares, contents


def threads(setup, part):
    """Return what a process may use, in place of each number."""
    return [{name: os.environ.get(name) for name in ONE_THREAD}] * len(part)


def dies_once(folder, part):
    """Kill the process at the first sight of the part that holds 30."""
    mark = os.path.join(folder, "died")
    if 30 in part and not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return [n * n for n in part]


def dies_always(setup, part):
    """Kill the process."""
    os.kill(os.getpid(), signal.SIGKILL)


def results(work, setup, jobs=2, parts=10):
    """Return the results of some parts by processes."""
    items = [(k, list(range(10 * k, 10 * k + 10))) for k in range(parts)]
    with Engine(jobs).ready(work, setup) as give:
        return dict(give(iter(items)))


def test_two_processes_leave_the_same_bytes_as_one(tmp_path):
    run_batch(Squares(), tmp_path / "one")
    run_batch(Squares(), tmp_path / "two", Engine(jobs=2))
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


def test_a_process_of_many_has_one_thread():
    found = results(threads, None, parts=2)
    assert found[0][0] == dict.fromkeys(ONE_THREAD, "1")


def test_a_killed_process_is_replaced_and_its_part_done_again(tmp_path):
    found = results(dies_once, str(tmp_path))
    assert (tmp_path / "died").exists()
    assert found == {k: [n * n for n in range(10 * k, 10 * k + 10)] for k in range(10)}


def test_processes_that_always_die_end_the_run_with_a_reason():
    with pytest.raises(RccError, match="the processes die") as raised:
        results(dies_always, None)
    assert "the same command goes on" in raised.value.hint


@pytest.fixture(scope="module")
def cluster():
    """Return a Dask cluster whose workers are threads of this process."""
    distributed = pytest.importorskip("dask.distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0"
    ) as found:
        yield found


def test_dask_leaves_the_same_bytes_as_one_process(tmp_path, cluster):
    run_batch(Squares(), tmp_path / "one")
    engine = Engine(dask=cluster.scheduler_address)
    run_batch(Squares(), tmp_path / "dask", engine)
    assert contents(tmp_path / "one") == contents(tmp_path / "dask")


def test_workers_with_another_version_are_refused_before_anything_starts(
    tmp_path, cluster, monkeypatch
):
    here, home = engine.version(), threading.get_ident()

    def version():
        return here if threading.get_ident() == home else ("0.0.1", "another")

    monkeypatch.setattr(engine, "version", version)
    with pytest.raises(InputError, match=r"has rccsim 0\.0\.1, here it is"):
        run_batch(Squares(), tmp_path / "out", Engine(dask=cluster.scheduler_address))
    assert list(tmp_path.iterdir()) == []


def test_a_scheduler_that_is_not_there_is_said_before_anything_starts(
    tmp_path, monkeypatch
):
    pytest.importorskip("dask.distributed")
    monkeypatch.setattr(engine, "CONNECT_S", 1)
    with pytest.raises(InputError, match="no scheduler there"):
        run_batch(Squares(), tmp_path / "out", Engine(dask="tcp://127.0.0.1:9"))
    with pytest.raises(InputError, match="no scheduler there"):
        run_batch(Squares(), tmp_path / "out", Engine(dask="nonsense://"))
    with pytest.raises(InputError, match="give one of them"):
        run_batch(Squares(), tmp_path / "out", Engine(jobs=2, dask="tcp://a:1"))
    assert list(tmp_path.iterdir()) == []


def test_a_scheduler_without_workers_is_said(tmp_path):
    distributed = pytest.importorskip("dask.distributed")
    with (
        distributed.LocalCluster(
            n_workers=0, processes=False, dashboard_address=":0"
        ) as empty,
        pytest.raises(InputError, match="has no workers"),
    ):
        run_batch(Squares(), tmp_path / "out", Engine(dask=empty.scheduler_address))


@pytest.mark.skipif(os.name == "nt", reason="there are no such signals")
def test_an_interrupt_that_another_thread_takes_waits_as_well():
    """Python raises it in the main thread, whatever that one blocks."""
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    found = signal.signal(signal.SIGINT, signal.default_int_handler)
    before, done = signal.default_int_handler, []
    try:
        with pytest.raises(KeyboardInterrupt), _unheard():
            signal.pthread_kill(other.ident, signal.SIGINT)
            time.sleep(0.05)
            done.append("made")
    finally:
        over.set()
        other.join()
    after = signal.signal(signal.SIGINT, found)
    assert done == ["made"] and after is before
