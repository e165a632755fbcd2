"""Keys of a campaign file that would have no effect beside others are refused in one line."""

import pytest

from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.sampling import draw
from lockstep import InputError

INPUT = '[input.{name}]\nparameter = "a.{name}"\n{values}\n'
U, GAIN = (INPUT.format(name=name, values='distribution = "uniform"') for name in ("u", "gain"))
LISTS = "".join(INPUT.format(name=name, values="values = [1.0]") for name in ("u", "gain"))
NUMBER = INPUT.format(name="gain", values='distribution = "case"')
CORRELATED = '[[correlation]]\nof = ["{}", "{}"]\nvalue = {}\n'
BAND = '[[band]]\nsignal = "a.y"\nperiod = 0.1\nresolution = 1.0\nunit = "deg"\n'
TEN = "cases = 10"


@pytest.mark.parametrize(
    ("campaign", "tables", "message"),
    [
        (f'{TEN}\nscenario = "slew"', U, "campaign: scenario: has no effect: it chooses among the systems that are b"),
        (
            f'{TEN}\nrecord = "a.y"',
            U + '[metric.cost]\nof = "paper"\ntake = "total_cost"\n',
            'campaign: record: has no effect: beside a metric of = "paper" all is recorded that the system file says',
        ),
        (
            'sampling = "grid"',
            LISTS + CORRELATED.format("u", "gain", 0.5),
            "correlation: sampling = 'grid' draws nothing; leave it out",
        ),
        (TEN, U + NUMBER + CORRELATED.format("u", "gain", 0.5), "correlation: gain is the number of the case, and not"),
        (
            TEN,
            U + GAIN + CORRELATED.format("u", "gain", 0.5) + CORRELATED.format("gain", "u", 0.4),
            "correlation 2: gain and u have another correlation above; leave one out",
        ),
        (
            TEN,
            INPUT.format(name="u", values='distribution = "norm"\nround = "yes"'),
            "round = 'yes': must be true or f",
        ),
        (
            TEN,
            INPUT.format(name="u", values="values = [1.5]\nround = true"),
            "input.u: round: has an effect with a dis",
        ),
        (f'{TEN}\nhistories = "worst"\nworst = 0\nby = "largest"', U, "campaign: worst = 0: must be a number of runs"),
        (f'{TEN}\nhistories = "bands"', U + BAND, "band 1: unit = 'deg': the resolution of a recorded signal is in"),
    ],
)
def test_a_key_without_effect_is_refused(campaign_file, campaign, tables, message):
    with pytest.raises(InputError) as refused:
        read_campaign(campaign_file(campaign, tables))

    assert str(refused.value).startswith("toy.toml: ")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_column_that_stands_twice_in_a_table_is_refused(campaign_file, tmp_path):
    (tmp_path / "cases.csv").write_text("u, u\n1.0,2.0\n")
    campaign = read_campaign(
        campaign_file('sampling = "table"\ntable = "cases.csv"', INPUT.format(name="u", values=""))
    )

    with pytest.raises(InputError, match=r"cases\.csv: column u: stands there twice; remove one of them"):
        draw(campaign)
