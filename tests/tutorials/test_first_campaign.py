"""The tutorial of a campaign runs as written."""

import json

from tutorials.as_written import run_with_fmus


def test_the_first_campaign_runs_top_to_bottom(delivered, tmp_path):
    run_with_fmus("docs/first_campaign", delivered, tmp_path)
    [system] = json.loads((tmp_path / "statistics.json").read_text())["systems"]
    assert system["requirements"][0]["met"] == 10
