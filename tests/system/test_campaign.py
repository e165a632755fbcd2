"""The example of 64 short runs of both layouts, shorter still: on one process and on two."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from flexbench.campaign.campaign import run_campaign
from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.orders import prepare
from flexbench.engine.pools import LocalPool

EXAMPLES = Path(__file__).parents[2] / "examples" / "campaigns"


def test_64_short_runs(delivered, tmp_path):
    path = tmp_path / "short.toml"
    text = (EXAMPLES / "short.toml").read_text()
    path.write_text(text.replace("stop_time = 2.0", "stop_time = 0.2").replace("../../fmus", str(delivered)))
    results = run_campaign(path, tmp_path / "out", lambda settings: LocalPool(settings, 2), lambda _: None).results

    assert results.numbers.tolist() == list(range(1, 65))
    assert results.completed.all(), results.causes
    assert results.systems == ["distributed", "centralised"] * 32
    for values in results.inputs.values():
        assert values[::2] == values[1::2]  # both layouts of a case have the same draws
    frequency = np.array(results.inputs["frequency"][::2])
    assert sorted(((frequency + 0.05) / 0.1 * 32).astype(int).tolist()) == list(range(32))  # a Sobol net
    assert len(set(results.metrics["pointing"].tolist())) == 64
    bands = pq.read_table(tmp_path / "out/bands.parquet").to_pydict()
    assert set(bands["runs"]) == {32}
    assert len(bands["time"]) == 2 * 2  # 0 and 0.1 s, of both: the last row of a loop begins no interval


def test_the_example_of_1000_runs_is_what_the_page_says(delivered, tmp_path):
    path = tmp_path / "layouts.toml"
    path.write_text((EXAMPLES / "layouts.toml").read_text().replace("../../fmus", str(delivered)))
    orders = prepare(read_campaign(path), tmp_path / "out", lambda _: None)

    assert len(orders) == 1000
    assert {orders.order(number).wanted.stop_time for number in (1, 1000)} == {300.0}
