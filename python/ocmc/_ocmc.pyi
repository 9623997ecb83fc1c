from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, SupportsIndex, TypeAlias, final

import numpy.typing as npt
import pandas as pd  # type: ignore[import-untyped]
import polars as pl

from ocmc._answer import Answer
from ocmc._summary import Summary

# fmt: off
__all__ = [
    "OperatingCycle", "Run", "Study", "Table", "__version__", "benchmark", "calibrate_curve_speed",
    "compare", "detect_curves", "fit_curve_speed", "fit_fleet", "fit_operating_cycle",
    "fit_speed_change", "fit_traffic", "fit_weather", "identify", "joined", "label", "learn",
    "load", "merge", "mixed_fleet", "road", "run_from", "simulator_study", "studies", "unpickled",
    "unpickled_table", "validate", "vehicles",
]
# fmt: on

__version__: str

_Path: TypeAlias = str | PathLike[str]
_Format: TypeAlias = Literal["parquet", "csv"]
_Columns: TypeAlias = Mapping[str, str] | None
_Array: TypeAlias = npt.NDArray[Any]
_Progress: TypeAlias = bool | Callable[[int, int], object] | None

def load(path: _Path) -> Run: ...

# fmt: off
def compare(
    a: Study, b: Study, *, cycles: SupportsIndex, seed: SupportsIndex = 1,
    first_cycle: SupportsIndex = 0, column: str | None = None, out: _Path | None = None,
    format: _Format | None = None, names: Sequence[str] | None = None,
    threads: SupportsIndex | None = None, progress: _Progress = None,
) -> Answer: ...
def mixed_fleet(
    study: _Path | Mapping[str, Any], *, seed: SupportsIndex = 1, out: _Path | None = None,
    format: _Format | None = None, threads: SupportsIndex | None = None, progress: _Progress = None,
) -> Answer: ...
def benchmark(
    trips: object, study: Study, *, columns: _Columns = None, since: str | None = None,
    group: str | None = None, names: bool = False, speed: bool = True, cycles: int = 3200,
    seed: SupportsIndex = 1, threads: SupportsIndex | None = None, out: _Path | None = None,
    progress: _Progress = None,
) -> Answer: ...
def calibrate_curve_speed(
    curves: object, study: Study, *, columns: _Columns = None, drivers: int = 240, trips: int = 1,
    seed: int = 1, least_residual_sd: float = 0.048,
    radius_range_m: tuple[float, float] = (20.0, 500.0), least_lateral_mps2: float = 0.0,
    progress: _Progress = None,
) -> Answer: ...
def learn(
    folder: _Path, *, base: str = "field-truck", name: str = "my-fleet", columns: _Columns = None,
    hold_back: float = 0.2, amount_noise: float = 0.03, weight_noise: float = 0.05,
    seed: SupportsIndex = 1, threads: SupportsIndex | None = None, page: _Path | None = None,
    progress: _Progress = None,
) -> Answer: ...
# fmt: on
def detect_curves(
    log: object,
    *,
    columns: _Columns = None,
    detector: Literal["hidden_markov", "trained", "threshold"] = "hidden_markov",
    radius: Literal["turn", "mean", "positions"] = "turn",
    central_share: float | None = None,
    split_ratio: float | None = None,
    gyro_bias_radps: float | None = None,
    speed_lag_s: float | None = None,
    steering_ratio: float | None = None,
    wheelbase_m: float | None = None,
) -> Table: ...
def fit_curve_speed(
    curves: object,
    *,
    columns: _Columns = None,
    base: Study | None = None,
    tobit: bool = False,
    reference_radius_m: float = 250.0,
    radius_range_m: tuple[float, float] = (20.0, 500.0),
    minimum_route_m: float = 5000.0,
    isolated_m: float | None = None,
    least_lateral_mps2: float = 0.0,
    fixed_exponent: float = 0.5,
    significance: float = 0.05,
    limit_share: float = 0.9,
    coding: Literal["sum_to_zero", "treatment"] = "sum_to_zero",
) -> Answer: ...
def fit_speed_change(
    table: object,
    *,
    columns: _Columns = None,
    base: Study | None = None,
    untruncated: bool = False,
    window_s: float = 2.0,
    smallest_acceleration_mps2: float = 0.2,
    smallest_deceleration_mps2: float = 0.4,
) -> Answer: ...
def fit_operating_cycle(
    cycles: object,
    *,
    columns: _Columns = None,
    base: Study | None = None,
    radius_range_m: tuple[float, float] | None = None,
    road_type: str | None = None,
    altitude_average_m: float = 200.0,
    mission_stop_s: float = 300.0,
    split_ratio: float | None = None,
    steering_ratio: float | None = None,
    wheelbase_m: float | None = None,
) -> Answer: ...
def fit_fleet(
    records: object,
    *,
    columns: _Columns = None,
    column: str | None = None,
    weight: str | None = None,
    own_drivers: bool = False,
    month: bool = False,
    differ: float = 0.01,
    power: float = 0.8,
    next_trips: SupportsIndex | None = None,
    best: Literal["lowest", "highest"] = "lowest",
    draws: SupportsIndex = 4000,
    seed: SupportsIndex = 1,
) -> Answer: ...

# fmt: off
def fit_traffic(
    table: object, *, columns: _Columns = None, base: Study | None = None,
    utc_offset_h: float | None = None, zone: str | None = None,
) -> Answer: ...
def fit_weather(
    table: object, *, columns: _Columns = None, base: Study | None = None,
    utc_offset_h: float | None = None, zone: str | None = None,
) -> Answer: ...
# fmt: on
def identify(
    logs: object,
    study: Study,
    *,
    columns: _Columns = None,
    controller: Literal["pid", "switched"] = "pid",
    speed_term: Literal["none", "measured", "simulated"] = "none",
    unknown: Sequence[Literal["delay", "mass", "resistance", "none"]] | None = None,
    starts: SupportsIndex = 8,
    kp: tuple[float, float] = (0.01, 2.0),
    ki: tuple[float, float] = (0.0001, 0.2),
    kd: tuple[float, float] = (0.0, 2.0),
    intervals: bool = True,
    progress: _Progress = None,
) -> Answer: ...

# fmt: off
def road(
    logs: object, *, columns: _Columns = None, limit_mps: float | None = None,
    road_type: str | None = None, stops: bool = True, split_ratio: float | None = None,
    steering_ratio: float | None = None, wheelbase_m: float | None = None,
) -> Answer: ...
# fmt: on
def validate(
    logs: object,
    study: Study,
    *,
    road: _Path | None = None,
    trips: SupportsIndex = 2000,
    seed: SupportsIndex = 1,
    columns: _Columns = None,
    keep: Sequence[Literal["weather", "traffic", "mission"]] | None = None,
    limit_mps: float | None = None,
    road_type: str | None = None,
    stops: bool = True,
    split_ratio: float | None = None,
    steering_ratio: float | None = None,
    wheelbase_m: float | None = None,
    run_in_m: float = 500.0,
    out: _Path | None = None,
    threads: SupportsIndex | None = None,
    progress: _Progress = None,
) -> Answer: ...
def simulator_study(
    study: Study,
    *,
    repetitions: SupportsIndex = 40,
    seed: SupportsIndex = 1,
    gains: bool = True,
    speed_term: Literal["simulated", "measured", "none"] = "simulated",
    out: _Path | None = None,
    threads: SupportsIndex | None = None,
    progress: _Progress = None,
) -> Answer: ...
def studies() -> dict[str, str]: ...
def vehicles() -> dict[str, str]: ...
def merge(parts: Sequence[_Path], *, out: _Path, format: _Format | None = None) -> Run: ...
def run_from(arguments: Sequence[str]) -> int: ...
def label(column: str) -> tuple[str, float]: ...
def joined(parts: Sequence[Run], wall_s: float, threads: int) -> Run: ...
def unpickled(
    manifest: str, wall_s: float, threads: int, ended_at: str, stream: bytes, sum: bytes
) -> Run: ...
def unpickled_table(stream: bytes, sum: bytes) -> Table: ...

@final
class Study:
    def __new__(cls, source: _Path | Mapping[str, Any], allow_files: bool = True) -> Study: ...
    @property
    def name(self) -> str: ...
    @property
    def hash(self) -> str: ...
    def set(self, path: str, value: object) -> Study: ...
    def to_dict(self) -> dict[str, Any]: ...
    def to_toml(self) -> str: ...
    def diff(self, other: Study) -> Answer: ...
    def run(
        self,
        *,
        cycles: SupportsIndex | None = None,
        trucks: SupportsIndex | None = None,
        trips: SupportsIndex | None = None,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        threads: SupportsIndex | None = None,
        precision: str | None = None,
        out: _Path | None = None,
        resume: bool = False,
        format: _Format | None = None,
        progress: _Progress = None,
    ) -> Run: ...
    def drive(
        self,
        files: object,
        *,
        cycles: SupportsIndex,
        columns: _Columns = None,
        keep: Sequence[Literal["weather", "traffic", "mission"]] | None = None,
        draw: Sequence[Literal["stops", "limits", "hills", "curves"]] | None = None,
        stop_plan: _Path | None = None,
        follow_speed: Literal["driver", "exact"] | None = None,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Run: ...
    def birds_eye(
        self,
        *,
        cycles: SupportsIndex = 100,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        laws: bool = False,
    ) -> Answer: ...
    def bound(
        self,
        *,
        cycles: SupportsIndex,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    # fmt: off
    def cost(
        self, *, cycles: SupportsIndex | None = None, trucks: SupportsIndex | None = None,
        trips: SupportsIndex | None = None, against: Study | None = None, seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0, threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    # fmt: on
    def training(
        self,
        *,
        trucks: SupportsIndex,
        trips: SupportsIndex | None = None,
        share: float = 0.2,
        coached: dict[str, Any] | None = None,
        seed: SupportsIndex = 1,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    def range(
        self,
        *,
        cycles: SupportsIndex,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    def size(
        self,
        *,
        cycles: SupportsIndex,
        arrive: float | Sequence[float] = 0.95,
        kg_per_kwh: float = 0.0,
        season: Literal["winter", "spring", "summer", "autumn"] | None = None,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    # fmt: off
    def sensitivity(
        self, *, cycles: SupportsIndex, seed: SupportsIndex = 1, first_cycle: SupportsIndex = 0,
        column: str | None = None, factors: Sequence[str] | None = None,
        over: Literal["trip", "truck"] = "trip", crossed: SupportsIndex | None = None,
        shapley: bool = False, out: _Path | None = None, threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    def sweep(
        self, points: object, *, cycles: SupportsIndex, against: Literal["first", "base"] = "first",
        seed: SupportsIndex = 1, first_cycle: SupportsIndex = 0, column: str | None = None,
        threads: SupportsIndex | None = None, progress: _Progress = None,
    ) -> Answer: ...
    # fmt: on
    def doubt(
        self,
        *,
        cycles: SupportsIndex,
        against: Study | None = None,
        seed: SupportsIndex = 1,
        first_cycle: SupportsIndex = 0,
        column: str | None = None,
        out: _Path | None = None,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    def calibrate_totals(
        self,
        trips: object,
        *,
        columns: _Columns = None,
        amount_noise: float = 0.03,
        weight_noise: float = 0.05,
        seed: SupportsIndex = 1,
        threads: SupportsIndex | None = None,
        progress: _Progress = None,
    ) -> Answer: ...
    def operating_cycle(
        self, cycle_id: SupportsIndex, *, seed: SupportsIndex = 1
    ) -> OperatingCycle: ...
    def trace(self, cycle_id: SupportsIndex, *, seed: SupportsIndex = 1) -> Table: ...
    def __getattr__(self, name: str, /) -> Any: ...  # noqa: ANN401 (whatever a key holds)
    def __getitem__(self, path: str, /) -> Any: ...  # noqa: ANN401 (whatever a key holds)
    def __dir__(self) -> list[str]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[type[Study], tuple[dict[str, Any], bool]]: ...

@final
class Run:
    @property
    def columns(self) -> list[str]: ...
    @property
    def records(self) -> Table: ...
    @property
    def trucks(self) -> Table | None: ...
    def loads(self) -> Table | None: ...
    def chargings(self) -> Table: ...
    @property
    def routes(self) -> list[dict[str, Any]]: ...
    @property
    def study(self) -> Study: ...
    @property
    def seed(self) -> int: ...
    @property
    def first_cycle(self) -> int: ...
    def summary(self) -> Summary: ...
    def report(self) -> str: ...
    def save(self, path: _Path, *, format: _Format = "parquet") -> None: ...
    def to_excel(self, path: _Path) -> None: ...
    def to_pandas(self) -> pd.DataFrame: ...
    def to_polars(self) -> pl.DataFrame: ...
    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> _Array: ...
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __getitem__(self, column: str, /) -> _Array: ...
    def __contains__(self, column: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __reduce__(self) -> tuple[Callable[..., Run], tuple[str, float, int, bytes, bytes]]: ...

@final
class Table:
    @property
    def columns(self) -> list[str]: ...
    def keys(self) -> list[str]: ...
    def to_dict(self) -> dict[str, _Array]: ...
    def to_pandas(self) -> pd.DataFrame: ...
    def to_polars(self) -> pl.DataFrame: ...
    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> _Array: ...
    def __getitem__(self, column: str, /) -> _Array: ...
    def __contains__(self, column: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __reduce__(self) -> tuple[Callable[..., Table], tuple[bytes, bytes]]: ...

@final
class OperatingCycle:
    @property
    def cycle_id(self) -> int: ...
    @property
    def seed(self) -> int: ...
    @property
    def length_m(self) -> float: ...
    def keys(self) -> list[str]: ...
    def items(self) -> list[tuple[str, dict[str, Any]]]: ...
    def to_table(self) -> Table: ...
    def __getitem__(self, name: str, /) -> dict[str, Any]: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> _Array: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
