"""The tutorial of a vendor's controller runs as written."""

from tutorials.as_written import run_with_fmus


def test_controller_in_the_loop_runs_top_to_bottom(delivered, tmp_path):
    run_with_fmus("docs/controller_in_the_loop", delivered, tmp_path)
