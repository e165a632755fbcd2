"""The tutorial of FMUs for other tools runs as written."""

from tutorials.as_written import run_with_fmus


def test_fmus_for_other_tools_runs_top_to_bottom(delivered, tmp_path):
    run_with_fmus("docs/fmus_for_other_tools", delivered, tmp_path)
