"""A campaign ends where its rule is satisfied, whatever is finished beside; Saltelli designs."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.sampling import draw
from flexbench.campaign.statistics.sensitivities import saltelli_points
from flexbench.campaign.stop import StopRule
from lockstep import InputError

INPUTS = """
[input.u]
parameter = "a.u"
distribution = "uniform"
loc = 1.0
scale = 0.2

[input.gain]
parameter = "a.gain"
distribution = "norm"
loc = 1.0
scale = 0.1
"""


def test_a_campaign_ends_at_the_look_that_satisfies_its_rule(campaign_file, fly, tmp_path):
    path = campaign_file("cases = 150", INPUTS)
    said = []
    rule = StopRule("mean(largest) within 2 %", read_campaign(path), said.append)
    done = fly(path, tmp_path / "out", 3, until=rule)
    assert done.stopped
    assert len(done.results.numbers) == 50  # the first look, however many of the next ones are finished too
    assert done.results.numbers.tolist() == list(range(1, 51))
    values = done.results.metrics["largest"]
    assert rule.states[0].satisfied
    assert 1.96 * values.std() / np.sqrt(50) < 0.02 * values.mean()  # Student's bounds are hardly wider here
    assert len(said) == 1
    assert said[0].startswith("50 runs: mean(largest) within 2 %, toy: within ")

    strict = StopRule("mean(largest) within 0.01 %", read_campaign(path), said.append)
    results = done.results
    assert not strict(results)
    assert not strict(results)  # not looked at again before a quarter more
    assert "about" in said[-1]
    assert len(said) == 2


def test_a_saltelli_design_is_drawn_through_the_distributions(campaign_file):
    campaign = read_campaign(campaign_file('cases = 8\nsampling = "saltelli"', INPUTS))
    cases = draw(campaign)
    points = saltelli_points(2, 8, campaign.seed)
    assert len(cases) == 8 * 4
    assert_allclose([case["u"] for case in cases], 1.0 + 0.2 * points[:, 0])
    a, b, first, second = (np.array([[c["u"], c["gain"]] for c in cases[k : k + 8]]) for k in range(0, 32, 8))
    assert np.array_equal(first, np.column_stack([b[:, 0], a[:, 1]]))
    assert np.array_equal(second, np.column_stack([a[:, 0], b[:, 1]]))


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            '[input.seed]\nparameter = "a.seed"\ndistribution = "case"\n',
            "seed: distribution = 'case': Sobol indices",
        ),
        ('[[correlation]]\nof = ["u", "gain"]\nvalue = 0.5\n', "correlation: Sobol indices are those of independent"),
    ],
)
def test_what_a_saltelli_design_cannot_have_is_refused(campaign_file, tables, message):
    with pytest.raises(InputError, match=message):
        read_campaign(campaign_file('cases = 8\nsampling = "saltelli"', INPUTS + tables))
    with pytest.raises(InputError, match="cases = 9: Sobol sequences need a power of 2, such as 16"):
        read_campaign(campaign_file('cases = 9\nsampling = "saltelli"', INPUTS))
