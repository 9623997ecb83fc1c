"""Runs on a Dask cluster: the same records, whatever happens to the workers."""

import json
import os
import signal
import threading

import numpy as np
import ocmc
import pytest

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
pa = pytest.importorskip("pyarrow")

CYCLES = 2000

# what Dask itself says of its servers while a worker is killed and at the end is not ours
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def client():
    """Two worker processes of two threads each."""
    with (
        # a call of a worker that has just been lost waits so long, and 30 s without being told
        dask.config.set({"distributed.comm.timeouts.connect": "10s"}),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=2,
            processes=True,
            dashboard_address=None,
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def whole(study):
    return study.run(cycles=CYCLES, seed=7, first_cycle=10)


def test_shards_hold_whole_trucks(study, client):
    fleet = study.set("fleet.trips_per_truck", 7)
    run = ocmc.dask.run(fleet, cycles=210, shard_cycles=50, client=client)
    alone = fleet.run(cycles=210)
    assert pa.table(run.records).combine_chunks().equals(pa.table(alone.records).combine_chunks())
    assert pa.table(run.trucks).equals(pa.table(alone.trucks))


def test_a_cluster_gives_the_records_of_one_run(study, whole, client, tmp_path):
    calls = []
    run = ocmc.dask.run(
        study,
        cycles=CYCLES,
        seed=7,
        first_cycle=10,
        client=client,
        progress=lambda done, total: calls.append((done, total)),
    )
    assert pa.table(run.records).combine_chunks().equals(pa.table(whole.records).combine_chunks())
    whole.save(tmp_path / "whole")
    run.save(tmp_path / "cluster")
    for name in ["records.parquet", "manifest.json"]:
        assert (tmp_path / "whole" / name).read_bytes() == (
            tmp_path / "cluster" / name
        ).read_bytes(), name
    summary, expected = run.summary(), whole.summary()
    assert summary["threads"] == 4
    for key in ["wall_s", "threads", "ended_at"]:
        summary.pop(key, None)
        del expected[key]
    assert summary == expected
    assert calls[-1] == (CYCLES, CYCLES)
    assert len(calls) > 3


def test_the_records_do_not_depend_on_the_shards(study, whole, client):
    run = ocmc.dask.run(
        study, cycles=CYCLES, seed=7, first_cycle=10, client=client, shard_cycles=333
    )
    np.testing.assert_array_equal(run["fuel_kg"], whole["fuel_kg"])
    assert run["cycle_id"].tolist() == whole["cycle_id"].tolist()


def test_the_shard_of_a_lost_worker_is_driven_again(study, whole, client):
    pids = list(client.run(os.getpid).values())
    killed = threading.Event()

    def kill(done, total):
        if not killed.is_set():
            assert 0 < done < total, "some shards are done, some are not"
            os.kill(pids[0], signal.SIGKILL)
            killed.set()

    run = ocmc.dask.run(
        study, cycles=CYCLES, seed=7, first_cycle=10, client=client, shard_cycles=50, progress=kill
    )
    assert killed.is_set()
    assert pids[0] not in client.run(os.getpid).values()
    assert pa.table(run.records).combine_chunks().equals(pa.table(whole.records).combine_chunks())


def test_parts_on_shared_storage(study, whole, client, tmp_path):
    out = tmp_path / "parts"
    given = {"cycles": CYCLES, "seed": 7, "first_cycle": 10, "client": client, "shard_cycles": 600}
    parts = ocmc.dask.run(study, **given, out=out)
    assert sorted(out.iterdir()) == parts
    assert [len(ocmc.load(part)) for part in parts] == [600, 600, 600, 200]
    # a worker of two threads takes two shards, each on one thread
    assert {ocmc.load(part).summary()["threads"] for part in parts} == {1}
    fuel = np.concatenate([ocmc.load(part)["fuel_kg"] for part in parts])
    np.testing.assert_array_equal(fuel, whole["fuel_kg"])

    # what is there is kept, what is missing is driven
    before = (parts[0] / "records.parquet").stat().st_mtime_ns
    for file in parts[2].iterdir():
        file.unlink()
    parts[2].rmdir()
    assert ocmc.dask.run(study, **given, out=out) == parts
    assert (parts[0] / "records.parquet").stat().st_mtime_ns == before
    assert len(ocmc.load(parts[2])) == 600
    assert {json.loads((part / "manifest.json").read_text())["status"] for part in parts} == {
        "complete"
    }

    with pytest.raises(FileExistsError, match="holds another run"):
        ocmc.dask.run(study, **(given | {"seed": 8}), out=out)


def test_what_is_wrong_with_a_run_is_said(study, client):
    with pytest.raises(ValueError, match="`cycles` is 0"):
        ocmc.dask.run(study, cycles=0, client=client)
    with pytest.raises(ValueError, match="`shard_cycles` is -1"):
        ocmc.dask.run(study, cycles=10, client=client, shard_cycles=-1)
    with pytest.raises(ValueError, match="`seed` is -1"):
        ocmc.dask.run(study, cycles=10, client=client, seed=-1)
