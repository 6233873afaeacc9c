"""Any number of threads may use one engine, and Python goes on meanwhile."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy
from conftest import taken

import slipstream


def test_eight_threads_share_an_engine(dual, engine):
    bright = numpy.stack(list(dual.scan.frames))
    dim = bright // 2
    right = [engine.cloud(bright).z.copy(), engine.cloud(dim).z.copy()]

    def work(n):
        cloud = engine.cloud(bright if n % 2 == 0 else dim)
        points = cloud.points
        return (numpy.array_equal(cloud.z, right[n % 2], equal_nan=True)
                and numpy.array_equal(points[..., 2], cloud.z, equal_nan=True))

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(200)))


def test_python_goes_on_while_clouds_are_made(dual):
    going = threading.Event()
    counted = [0]

    def count():
        going.set()
        while going.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    taken("pmp", camera=(640, 480), steps=3)  # one call that takes a second
    assert counted[0] > before
    going.clear()
    thread.join()


def test_threads_are_limited(dual, engine):
    with slipstream.threads(1):
        alone = engine.cloud(dual.scan.frames).z.copy()
    assert numpy.array_equal(engine.cloud(dual.scan.frames).z, alone, equal_nan=True)


def test_a_failure_in_a_thread_is_its_own(dual, engine):
    def work(n):
        try:
            return len(engine.cloud(dual.scan.frames if n % 2 else [numpy.zeros((2, 2), "u1")]))
        except slipstream.Error:
            return None

    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(work, range(40)))
    assert results[::2] == [None] * 20
    assert len(set(results[1::2])) == 1 and results[1] > 0
