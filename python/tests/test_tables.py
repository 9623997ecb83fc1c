"""Tables: Arrow, pandas, polars, duckdb and numpy see the same numbers, mostly without copies."""

import hashlib
import json
import pickle
import time

import numpy as np
import ocmc
import pytest

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")


@pytest.fixture(scope="module")
def table(run):
    return pa.table(run.records)


def test_the_records_are_an_arrow_table(run, table):
    assert table.num_rows == len(run) == len(run.records)
    assert table.column_names == run.columns == list(run.records)
    assert table.schema == pa.schema(run.records)
    assert table["battery_energy_j"].null_count == len(run)
    for name in run.columns:
        column = table[name].to_numpy()
        np.testing.assert_array_equal(column, run[name])
        np.testing.assert_array_equal(run.records[name], run[name])


def test_the_table_is_what_is_written(run, table, tmp_path):
    run.save(tmp_path / "run")
    assert pq.read_table(tmp_path / "run" / "records.parquet").equals(table)


def test_arrow_shares_the_memory(run):
    """Two tables of the same records lie at the same place, which also stays when the run goes."""
    first, second = pa.table(run.records), pa.table(run.records)
    for name in ["cycle_id", "distance_m"]:
        places = [t[name].chunk(0).buffers()[1].address for t in (first, second)]
        assert places[0] == places[1]
    short = ocmc.Study("field-truck").set("mission.length_m", 1000).run(cycles=20)
    kept = pa.table(short.records)
    expected = short["distance_m"]
    del short
    np.testing.assert_array_equal(kept["distance_m"], expected)


def test_polars_takes_them(run):
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame(run.records)
    assert frame.shape == (len(run), len(run.columns))
    assert frame["fuel_kg"].sum() == pytest.approx(run["fuel_kg"].sum(), rel=1e-12)
    assert frame["battery_energy_j"].null_count() == len(run)
    assert frame["outcome"].to_list() == run["outcome"].tolist()


def test_pandas_takes_them(run):
    pandas = pytest.importorskip("pandas")
    frames = [pa.table(run.records).to_pandas(), pandas.DataFrame(dict(run.records))]
    if hasattr(pandas.DataFrame, "from_arrow"):
        frames.append(pandas.DataFrame.from_arrow(run.records))
    for frame in frames:
        assert frame.shape == (len(run), len(run.columns))
        np.testing.assert_array_equal(frame["distance_m"].to_numpy(), run["distance_m"])
        assert frame["battery_energy_j"].isna().all()


def test_duckdb_takes_them(run):
    duckdb = pytest.importorskip("duckdb")
    records = run.records  # duckdb finds it by its name
    asked = (
        "SELECT sum(fuel_kg), count(battery_energy_j), count(*) FROM records WHERE outcome = "
        "'completed'"
    )
    fuel, batteries, rows = duckdb.sql(asked).fetchall()[0]
    completed = run["outcome"] == "completed"
    assert (batteries, rows) == (0, completed.sum())
    assert fuel == pytest.approx(run["fuel_kg"][completed].sum(), rel=1e-12)
    assert records is not None


def test_traces_and_operating_cycles_are_tables(study):
    trace = study.trace(3)
    arrow = pa.table(trace)
    assert arrow.column_names == trace.columns == list(dict(trace))
    np.testing.assert_array_equal(arrow["speed_mps"], trace["speed_mps"])
    cycle = study.operating_cycle(3)
    arrow = pa.table(cycle)
    assert arrow.column_names == ["track", "rule", "position_m", "value", "name"]
    for name, track in cycle.items():
        rows = arrow.filter(pa.compute.equal(arrow["track"], name))
        assert set(rows["rule"].to_pylist()) <= {track["rule"]}
        np.testing.assert_array_equal(rows["position_m"], track["position_m"])
        kept, other = ("name", "value") if track["value"].dtype.kind == "U" else ("value", "name")
        np.testing.assert_array_equal(rows[kept].to_numpy(), track["value"])
        assert rows[other].null_count == len(rows)
    np.testing.assert_array_equal(cycle.to_table()["position_m"], arrow["position_m"])
    assert (cycle.cycle_id, cycle.seed, cycle.length_m) == (3, 1, 5000.0)
    assert len(cycle) == len(list(cycle)) == len(cycle.keys())
    assert "grade" in cycle
    assert "grades" not in cycle
    with pytest.raises(KeyError, match="no track 'grades'"):
        cycle["grades"]


def test_a_table_is_a_mapping_of_its_columns(study):
    trace = study.trace(3)
    assert "speed_mps" in trace
    assert "speed" not in trace
    assert 3 not in trace
    assert trace.to_dict().keys() == dict(trace).keys()
    assert repr(trace).startswith(f"<ocmc.Table of {len(trace)} rows, ")
    with pytest.raises(KeyError, match="no column 'speed'"):
        trace["speed"]


def test_a_requested_schema_is_met_where_its_columns_are_ours(run, table):
    place = table.schema.get_field_index("distance_m")
    single = table.schema.set(place, pa.field("distance_m", pa.float32()))
    cast = pa.RecordBatchReader.from_stream(run.records, schema=single).read_all()
    assert cast.schema == single
    np.testing.assert_array_equal(cast["distance_m"], run["distance_m"].astype(np.float32))
    signed = table.schema.set(
        table.schema.get_field_index("cycle_id"), pa.field("cycle_id", pa.int64())
    )
    signed = signed.set(signed.get_field_index("outcome"), pa.field("outcome", pa.large_string()))
    cast = pa.RecordBatchReader.from_stream(run.records, schema=signed).read_all()
    assert cast.schema == signed
    assert cast["outcome"].to_pylist() == table["outcome"].to_pylist()
    # the protocol lets a producer keep its own schema where it cannot meet another one
    other = pa.RecordBatchReader.from_stream(
        run.records, schema=pa.schema([pa.field("x", pa.string())])
    )
    assert other.read_all().schema == table.schema


@pytest.mark.parametrize("wrong", [3, "x", object(), b"capsule"])
def test_what_is_no_schema_is_an_error(run, wrong):
    with pytest.raises((TypeError, ValueError)):
        run.records.__arrow_c_stream__(wrong)


def test_a_million_records_become_a_data_frame_in_a_second(run, tmp_path):
    """A quarter of a million rows in a quarter of a second: fixed costs make it harder."""
    pytest.importorskip("pandas")
    rows = 250_000
    large = _repeated(run, rows, tmp_path / "large")
    assert len(large) == rows
    best = np.inf
    for _ in range(7):
        begin = time.perf_counter()
        frame = pa.table(large.records).to_pandas()
        best = min(best, time.perf_counter() - begin)
    assert frame.shape == (rows, len(run.columns))
    np.testing.assert_array_equal(frame["fuel_kg"], np.resize(run["fuel_kg"], rows))
    print(f"{rows} records to pandas: {best:.3f} s")
    assert best < 0.25


def _repeated(run, rows, path):
    """A run of that many records, read from a directory that repeats a few cycles."""
    run.save(path)
    table = pa.table(run.records)
    table = pa.concat_tables([table] * -(-rows // len(table))).slice(0, rows)
    table = table.set_column(0, table.schema.field(0), pa.array(np.arange(rows, dtype=np.uint64)))
    pq.write_table(table, path / "records.parquet", compression="zstd")
    sums = {"records.parquet": hashlib.sha256((path / "records.parquet").read_bytes()).hexdigest()}
    manifest = json.loads((path / "manifest.json").read_text())
    manifest |= {"cycles": rows, "completed": rows}
    manifest |= {"records_sha256": sums["records.parquet"], "manifest_sha256": ""}
    text = json.dumps(manifest, indent=2)
    own = hashlib.sha256(text.encode()).hexdigest()
    text = text.replace('"manifest_sha256": ""', f'"manifest_sha256": "{own}"')
    (path / "manifest.json").write_text(text)
    sums["manifest.json"] = hashlib.sha256(text.encode()).hexdigest()
    with (path / "checksums.sha256").open("a") as file:
        file.writelines(f"{value}  {name}\n" for name, value in sums.items())
    return ocmc.load(path)


def test_a_pickled_run_is_the_same(run, tmp_path):
    other = pickle.loads(pickle.dumps(run))
    assert pa.table(other.records).equals(pa.table(run.records))
    assert other.summary() == run.summary()
    assert other.study == run.study
    run.save(tmp_path / "a")
    other.save(tmp_path / "b")
    for name in ["records.parquet", "manifest.json", "summary.json"]:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_pickled_table_is_the_same(study, run):
    for table in [run.records, study.trace(3), study.operating_cycle(0).to_table()]:
        other = pickle.loads(pickle.dumps(table))
        assert pa.table(other).equals(pa.table(table))


def test_notebooks_show_tables(study, run):
    for shown in [study, run, run.summary(), run.records, study.trace(3)]:
        html = shown._repr_html_()
        # a study has one for each of its tables
        tables = len(study.to_dict()) - 1 if shown is study else 1
        assert html.count("<table>") == html.count("</table>") == tables
    assert "field-truck" in study._repr_html_()
    assert f"{len(run)} of {len(run)} cycles completed" in run._repr_html_()
    assert "L/100 km" in run._repr_html_()
    assert "300 rows" in run.records._repr_html_()
