"""Write the folder of a campaign whose metrics are known functions of its inputs."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

ARCSECOND = np.pi / 648000.0
INPUTS = ("frequency", "damping", "inertia")


def write_campaign(folder, runs=300, systems=("distributed",), seed=1, sampling="random", inputs=INPUTS, times=0):
    """Write campaign.json and results.parquet, and bands.parquet with `times` rows a signal; return the folder.

    Pointing is lognormal and rises with the first input; settling rises with the second, and does not happen (inf) in
    some runs; momentum falls with the third. Runs 7, 107, 207 ... fail.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    cases = np.arange(1, runs + 1)
    draws = {name: rng.uniform(-0.1, 0.1, runs) for name in inputs}
    first, second, third = (draws[name] for name in inputs[:3])
    tables = []
    for k, system in enumerate(systems):
        noise = rng.standard_normal((3, runs))
        failed = cases % 100 == 7
        settling = 40.0 + 100.0 * second + noise[1]
        settling[cases % 100 == 50] = np.inf
        metrics = {
            "pointing": (1.0 + k) * 0.3 * np.exp(3.0 * first + 0.1 * noise[0]) * ARCSECOND,
            "settling": settling,
            "momentum": 20.0 - 30.0 * third + 0.3 * noise[2],
        }
        columns = {"number": cases + k * runs, "case": cases, "system": [system] * runs}
        columns |= {f"input.{name}": column for name, column in draws.items()}
        columns["input.camera"] = ["wide" if case % 2 else "narrow" for case in cases]
        columns |= {f"metric.{name}": pa.array(column, mask=failed) for name, column in metrics.items()}
        columns["status"] = ["failed" if one else "completed" for one in failed]
        columns["failure"] = ["crash" if one else "" for one in failed]
        columns["cause"] = ["controller: crashed at 12.3 s" if one else "" for one in failed]
        tables.append(pa.table(columns))
    pq.write_table(pa.concat_tables(tables), folder / "results.parquet")
    content = {
        "identity": "0", "path": "toy.toml", "name": "toy",
        "seed": seed, "cases": runs, "runs": runs * len(systems), "sampling": sampling,
        "systems": list(systems), "stop_time": 300.0,
        "inputs": [{"name": name, "kind": "parameter", "targets": [f"plant.{name}"], "unit": "1",
                    "distribution": "uniform", "discrete": False} for name in inputs]
        + [{"name": "camera", "kind": "parameter", "targets": ["sensors.camera"], "unit": None,
            "distribution": "values", "discrete": True}],
        "metrics": [
            {"name": "pointing", "unit": "rad", "shown_unit": "arcsec", "scale": ARCSECOND, "text": "rms of the error"},
            {"name": "settling", "unit": "s", "shown_unit": "s", "scale": 1.0, "text": "settling time"},
            {"name": "momentum", "unit": "N.m.s", "shown_unit": "N.m.s", "scale": 1.0, "text": "largest momentum"},
        ],
        "requirements": [
            {"name": "line of sight", "metric": "pointing", "most": 0.45 * ARCSECOND, "least": None,
             "probability": 0.9, "confidence": 0.95},
            {"name": "momentum left", "metric": "momentum", "most": None, "least": 16.0,
             "probability": 0.97, "confidence": 0.95},
        ],
        "files": {"distributed": "ab" * 32},
    }  # fmt: skip
    (folder / "campaign.json").write_text(json.dumps(content))
    if times:
        time = np.arange(times) * 0.05
        middle = np.exp(-time / 40.0) * np.sin(time)
        bands = [
            pa.table({"system": [system] * times, "signal": [signal] * times, "time": time, "runs": [runs] * times,
                      "least": middle - 1.0, "p05": middle - 0.5, "p50": middle, "p95": middle + 0.5,
                      "largest": middle + np.where(np.arange(times) == times // 2, 9.0, 1.0)})
            for system in systems for signal in ("pointing error", "rate error")
        ]  # fmt: skip
        pq.write_table(pa.concat_tables(bands), folder / "bands.parquet")
    return folder
