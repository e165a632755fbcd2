"""The draws of a campaign: distributions by quantiles, correlations, designs, tables; and what each input changes."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scipy.stats

from flexbench.campaign.campaign import run_campaign
from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.distributions import read_drawn
from flexbench.campaign.histories import Band, packed, percentiles, sampled, unpacked
from flexbench.campaign.order import with_delays
from flexbench.campaign.orders import prepare
from flexbench.campaign.sampling import draw
from flexbench.engine.pools import GivenPool
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, Connection, InputError, System, load_system, write_ssd

START = {"offset": 0.0, "number": 0, "flag": False}
PAIR = """
[input.x]
parameter = "a.u"
distribution = "expon"
scale = 2.0

[input.y]
parameter = "a.gain"
distribution = "norm"
loc = 5.0

[[correlation]]
of = ["x", "y"]
value = -0.6
"""


@pytest.mark.parametrize("sampling", ["random", "latin-hypercube", "sobol"])
def test_each_input_keeps_its_distribution_and_normal_scores_are_correlated(campaign_file, sampling):
    cases = draw(read_campaign(campaign_file(f'cases = 1024\nsampling = "{sampling}"', PAIR)))
    x, y = (np.array([case[name] for case in cases]) for name in ("x", "y"))
    scores = [scipy.stats.norm.ppf(scipy.stats.expon(scale=2.0).cdf(x)), y - 5.0]

    assert scipy.stats.kstest(x, scipy.stats.expon(scale=2.0).cdf).pvalue > 1e-3
    assert scipy.stats.kstest(y, scipy.stats.norm(loc=5.0).cdf).pvalue > 1e-3
    assert np.corrcoef(*scores)[0, 1] == pytest.approx(-0.6, abs=4.0 * 0.64 / 32.0)  # (1 - r^2)/sqrt(n), four times


def test_a_latin_hypercube_has_one_value_in_each_stratum(campaign_file):
    tables = PAIR.partition("[[correlation]]")[0]
    cases = draw(read_campaign(campaign_file('cases = 50\nsampling = "latin-hypercube"', tables)))
    shares = scipy.stats.expon(scale=2.0).cdf([case["x"] for case in cases])

    assert sorted((shares * 50).astype(int).tolist()) == list(range(50))


def test_draws_are_repeatable_and_depend_on_the_seed(campaign_file):
    first = draw(read_campaign(campaign_file("cases = 3", PAIR)))
    again = draw(read_campaign(campaign_file("cases = 5", PAIR)))
    other = campaign_file("cases = 3", PAIR)
    other.write_text(other.read_text().replace("seed = 5", "seed = 6"))

    assert again[:3] == first  # more random cases begin with the same ones
    assert draw(read_campaign(other)) != first


def test_grids_and_one_at_a_time(campaign_file):
    tables = (
        '[input.x]\nparameter = "a.u"\nvalues = [1.0, 2.0]\n{x}\n[input.y]\nparameter = "a.seed"\nvalues = [1, 2, 3]\n'
    )
    grid = draw(read_campaign(campaign_file('sampling = "grid"', tables.format(x=""))))
    assert [(case["x"], case["y"]) for case in grid] == [(x, y) for x in (1.0, 2.0) for y in (1, 2, 3)]

    text = tables.format(x="nominal = 1.5") + "nominal = 2\n"
    one = draw(read_campaign(campaign_file('sampling = "one-at-a-time"', text)))
    assert [(case["x"], case["y"]) for case in one] == [(1.5, 2), (1.0, 2), (2.0, 2), (1.5, 1), (1.5, 3)]


def test_correlations_that_contradict_each_other_are_refused(campaign_file):
    more = PAIR + '\n[input.z]\nparameter = "a.sleep"\ndistribution = "uniform"\n'
    more += '[[correlation]]\nof = ["x", "z"]\nvalue = 0.9\n[[correlation]]\nof = ["y", "z"]\nvalue = 0.9\n'
    with pytest.raises(InputError, match=r"correlation: those of x, y, z contradict each other"):
        draw(read_campaign(campaign_file("cases = 3", more)))


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        ({"distribution": "uniform", "loc": 1.0, "scale": 2.0}, [1.5, 2.0, 2.5]),
        ({"distribution": "randint", "low": 0, "high": 4}, [0, 1, 2]),
        ({"distribution": "norm", "scale": 10.0, "round": True}, [-7, 0, 7]),
        ({"values": ["a", "b"]}, ["a", "b", "b"]),
        ({"distribution": "case"}, [1, 2, 3]),
    ],
)
def test_values_at_quarters(entry, values):
    assert read_drawn(entry, "here").at(np.array([0.25, 0.5, 0.75])) == values


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    """Return a folder with a system of two FMUs, a file of faults and one of commands."""
    folder = tmp_path_factory.mktemp("loop")
    parts = [
        Component(name=name, source=wanderer(folder, "toy"), period=1_000_000, isolated=False, kind="sampled",
                  parameters=START | ({} if name == "b" else {"u": 1.0}))
        for name in "ab"
    ]  # fmt: skip
    wire = Connection(from_component="a", output="y", to_component="b", input="u")
    system = System(name="loop", tick=1_000_000, stop_time=20_000_000, components=tuple(parts), connections=(wire,))
    write_ssd(system, folder / "loop.ssd")
    (folder / "faults.toml").write_text(
        '[[fault]]\nname = "y drifts"\nconnection = "b.u"\nkind = "bias"\nvalue = 1.0\nfrom = 0.005\n'
    )
    (folder / "commands.csv").write_text("time,a.offset\n0.0,0.0\n0.01,1.0\n")
    return folder


def test_faults_delays_commands_and_systems_differ_between_runs(loop):
    path = loop / "loop.toml"
    path.write_text("""
[campaign]
sampling = "grid"
faults = "faults.toml"
commands = "commands.csv"
[input.which]
system = ["loop.ssd"]
[input.drift]
fault = "y drifts.value"
values = [0.5, 4.0]
[input.late]
delay = "a:b"
values = [1, 3]
[input.step]
command = "2:a.offset"
values = [1.0, 9.0]
[metric.y]
of = "b.y"
take = "max"
""")
    orders = prepare(read_campaign(path), loop / "out", lambda _: None)
    (one, *_, last) = [orders.order(number) for number in range(1, len(orders) + 1)]
    assert len(orders) == 8
    assert ("value = 0.5" in one.faults, "value = 4.0" in last.faults) == (True, True)
    assert [with_delays(load_system(loop / "loop.ssd"), of).connections[0].delay for of in (one, last)] == [1, 3]
    assert one.commands == "time,a.offset\n0.0,0.0\n0.01,1.0\n"
    assert last.commands == "time,a.offset\n0.0,0.0\n0.01,9.0\n"

    def in_threads(settings):
        return GivenPool(ThreadPoolExecutor(1), settings)  # any executor

    found = run_campaign(path, loop / "out", in_threads, lambda _: None).results
    assert found.completed.all(), found.causes
    values = found.metrics["y"].reshape(2, 2, 2)
    assert (np.diff(values, axis=0) > 0.0).all()  # more drift
    assert len(set(values.ravel().tolist())) == 8


def test_bands_are_exact_to_their_resolution():
    band = Band(signal="s", period=0.5, resolution=0.1)
    time = np.arange(0.0, 2.01, 0.25)
    runs = [sampled(time, np.sin(time) + k, band) for k in range(20)]
    found = percentiles([unpacked(packed(run)) for run in runs], band)

    assert found["time"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    for k, at in enumerate(found["time"]):
        values = np.rint((np.sin(at) + np.arange(20)) / 0.1) * 0.1
        assert found["p50"][k] == pytest.approx(np.quantile(values, 0.5, method="inverted_cdf"), abs=1e-12)
        assert found["p95"][k] == pytest.approx(np.quantile(values, 0.95, method="inverted_cdf"), abs=1e-12)
