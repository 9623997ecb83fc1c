"""Fixtures that the tests share."""

import contextlib
import threading
import time

import ocmc
import pytest


@pytest.fixture(scope="session")
def study():
    """A study with short cycles, so that tests are quick."""
    return ocmc.Study("field-truck").set("mission.length_m", 5000)


@pytest.fixture(scope="session")
def run(study):
    return study.run(cycles=300)


@pytest.fixture
def other_threads_go_on():
    """Give what checks that another thread runs while its block does."""

    @contextlib.contextmanager
    def checked():
        done, ticks = threading.Event(), []

        def tick():
            while not done.wait(0.002):
                ticks.append(None)

        ticker = threading.Thread(target=tick)
        ticker.start()
        begin = time.monotonic()
        try:
            yield
        finally:
            elapsed = time.monotonic() - begin
            done.set()
            ticker.join()
        assert elapsed > 0.1, "too short to tell"
        assert len(ticks) > 10 * elapsed

    return checked
