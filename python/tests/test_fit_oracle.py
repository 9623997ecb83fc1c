"""The fits beside statsmodels, where it is installed."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pandas = pytest.importorskip("pandas")
pytest.importorskip("statsmodels")

import statsmodels.api as sm  # noqa: E402
import statsmodels.formula.api as smf  # noqa: E402
from statsmodels.stats.diagnostic import normal_ad  # noqa: E402

COMMAND = Path(sys.executable).with_name("ocmc")


def answer(*arguments):
    done = subprocess.run(
        [COMMAND, *arguments, "--json"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module", params=[1, 2, 3])
def curves(request, tmp_path_factory):
    """Unbalanced data: drivers with 5 to 60 curves, more left ones, radii by the driver."""
    random = np.random.default_rng(request.param)
    counts = random.integers(5, 60, 12)
    driver = np.repeat(np.arange(12), counts)
    x = random.normal(-0.7, 0.8, len(driver)) + 0.1 * random.normal(size=12)[driver]
    x = np.clip(x, np.log(20 / 250), np.log(500 / 250))
    left = random.random(len(driver)) < 0.6
    level, slope = 2.7 + 0.08 * random.normal(size=12), 0.4 + 0.15 * random.normal(size=12)
    y = level[driver] + slope[driver] * x + np.where(left, 0.02, -0.02)
    y += 0.15 * random.normal(size=len(driver))
    direction = np.where(left, "left", "right")
    radius = 250 * np.exp(x)
    frame = pandas.DataFrame(
        {
            "driver": [f"d{k:02}" for k in driver],
            "radius_m": radius,
            "direction": direction,
            "speed_mps": np.exp(y),
        }
    )
    path = tmp_path_factory.mktemp("curves") / "curves.csv"
    frame.to_csv(path, index=False)
    frame = pandas.read_csv(path)
    frame["x"], frame["y"] = np.log(frame.radius_m / 250), np.log(frame.speed_mps)
    frame["side"] = np.where(frame.direction == "left", 1.0, -1.0)
    limits = ["--minimum-radius", "1", "--maximum-radius", "1000", "--significance", "1"]
    return frame, answer("fit", "curve-speed", path, *limits)


def test_analysis_of_variance(curves):
    frame, fit = curves
    terms = ["x", "C(driver, Sum)", "C(direction, Sum)"]
    full = smf.ols("y ~ " + " + ".join(terms), frame).fit()
    # sequential: each term beside those before it (the formula language would sort them otherwise)
    left = [smf.ols("y ~ " + " + ".join(["1", *terms[:k]]), frame).fit().ssr for k in range(4)]
    for k, row in enumerate(fit["anova"][:3]):
        assert row["sum_sq"] == pytest.approx(left[k] - left[k + 1], rel=1e-8)
    table = sm.stats.anova_lm(full, typ=3)
    for row, name in zip(fit["anova_marginal"], terms, strict=False):
        assert row["df"] == table.loc[name, "df"]
        for key, column in [("sum_sq", "sum_sq"), ("f", "F"), ("p", "PR(>F)")]:
            assert row[key] == pytest.approx(table.loc[name, column], rel=1e-7), (name, key)
    assert fit["anova"][-1]["sum_sq"] == pytest.approx(full.ssr, rel=1e-10)


def by_driver(columns, frame, place):
    """CR2 on matrices of all rows, as Bell and McCaffrey define it."""
    inverse = np.linalg.inv(columns.T @ columns)
    left = np.eye(len(columns)) - columns @ inverse @ columns.T
    residual = left @ frame.y.to_numpy()
    variance = 0.0
    for driver in frame.driver.unique():
        rows = np.flatnonzero(frame.driver == driver)
        values, vectors = np.linalg.eigh(left[np.ix_(rows, rows)])
        root = np.array([value**-0.5 if value > 1e-9 else 0.0 for value in values])
        pulls = (vectors * root) @ vectors.T @ columns[rows] @ inverse[:, place]
        variance += (pulls @ residual[rows]) ** 2
    return np.sqrt(variance)


def test_parameters_and_their_errors(curves):
    frame, fit = curves
    model = smf.ols("y ~ x + C(driver, Sum) + C(direction, Sum)", frame).fit()
    estimated = fit["estimated"]
    assert estimated["exponent"] == pytest.approx(model.params["x"], rel=1e-10)
    assert estimated["exponent_standard_error"] == pytest.approx(model.bse["x"], rel=1e-9)
    assert estimated["exponent_ci95"] == pytest.approx(list(model.conf_int().loc["x"]), rel=1e-8)
    assert np.log(estimated["reference_speed_mps"]) == pytest.approx(
        model.params["Intercept"], rel=1e-10
    )
    error = by_driver(model.model.exog, frame, list(model.params.index).index("x"))
    assert estimated["exponent_clustered_standard_error"] == pytest.approx(error, rel=1e-8)
    fixed = smf.ols("I(y - 0.5 * x) ~ C(driver, Sum) + C(direction, Sum)", frame).fit()
    assert fit["fixed"]["residual_sd"] == pytest.approx(np.sqrt(fixed.scale), rel=1e-10)


@pytest.mark.filterwarnings("ignore")  # statsmodels tells of its search
@pytest.mark.parametrize(("key", "effects"), [("random_intercept", "1"), ("random_slope", "1 + x")])
def test_random_effects(curves, key, effects):
    frame, fit = curves
    model = smf.mixedlm("y ~ x + side", frame, groups="driver", re_formula=effects)
    # its searches stop early now and then: the best of them counts
    fits = [model.fit(reml=True, method=method) for method in ["lbfgs", "bfgs", "powell", "nm"]]
    fitted = max((fit for fit in fits if np.isfinite(fit.llf)), key=lambda fit: fit.llf)
    ours = fit[key]
    assert ours["reml_criterion"] == pytest.approx(-2 * fitted.llf, abs=1e-3)
    assert ours["exponent"] == pytest.approx(fitted.fe_params["x"], rel=1e-3)
    assert ours["residual_sd"] == pytest.approx(np.sqrt(fitted.scale), rel=2e-3)
    assert ours["driver_sd"] == pytest.approx(np.sqrt(fitted.cov_re.iloc[0, 0]), rel=1e-2)
    assert ours["exponent_standard_error"] == pytest.approx(fitted.bse_fe["x"], rel=1e-2)


def test_goodness_of_fit(tmp_path):
    random = np.random.default_rng(4)
    samples = [
        np.exp(0.3 * random.normal(size=40)),
        0.5 + random.random(25),
        0.3 + random.exponential(size=60),
    ]
    for k, values in enumerate(samples):
        path = tmp_path / f"{k}.csv"
        pandas.DataFrame({"acceleration_mps2": values}).to_csv(path, index=False)
        law = answer("fit", "speed-change", path)["acceleration"]
        used = values[values > 0.2]
        assert law["n"] == len(used)
        square, p = normal_ad(np.log(used))
        assert law["anderson_darling"] == pytest.approx(square, rel=1e-8)
        assert law["anderson_darling_p"] == pytest.approx(p, rel=1e-6, abs=1e-12)
