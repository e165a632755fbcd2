"""Which figures are drawn of a design and of runs, and by what."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexbench.cli.parser import main
from flexbench.figures import figure_lists
from flexbench.figures.figure_lists import design_figures, result_figures
from flexbench.runs.run_folder import Run
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import RPM, ConfigurationName
from flexsat.variants import AS_PUBLISHED


def test_figures_of_a_design_are_listed_without_being_drawn(built: Any):
    assert set(design_figures(built)) == {
        "structure", "software", "mode-shapes", "campbell", "wheel-responses-centralised",
        "wheel-responses-distributed", "architecture-centralised", "architecture-distributed",
    }  # fmt: skip


def test_figures_as_published_are_those_of_25_modes_at_their_wheel_speeds(built: Any):
    """PHYSICS section 5: 351 and 223 rpm centralised, from 223 to 833 rpm distributed; the full plant's differ."""
    drawn = design_figures(built, AS_PUBLISHED)
    assert set(drawn) == {
        "mode-shapes-as-published", "campbell-as-published",
        "wheel-responses-centralised-as-published", "wheel-responses-distributed-as-published",
    }  # fmt: skip
    for name, slowest, fastest in (("centralised", 223, 351), ("distributed", 223, 833)):
        design = built[name].variant(AS_PUBLISHED)
        assert design.structure.mode_count == 25
        nominal = design.response.nominal / RPM
        assert (round(min(nominal)), round(max(nominal))) == (slowest, fastest)


def test_the_command_draws_the_design_as_published(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    def one_of_them(*given: Any) -> Any:
        """Return the figure that is drawn fastest."""
        return {name: draw for name, draw in design_figures(*given).items() if name.startswith("wheel")}

    monkeypatch.setattr(figure_lists, "design_figures", one_of_them)
    out = tmp_path / "drawn"
    assert main(["figures", "--as-published", "--configuration", "centralised", "--out", str(out)]) == 0
    assert {path.stem for path in out.iterdir()} == {"wheel-responses-centralised-as-published"}
    assert "351 rpm" in (out / "wheel-responses-centralised-as-published.svg").read_text()
    assert main(["figures", str(tmp_path), "--as-published", "--out", str(tmp_path / "refused")]) == 2
    assert "--as-published: has no effect on results" in capsys.readouterr().err


def run_of(name: ConfigurationName, **kind: Any) -> Run:
    given = {"slew": True, "seed": 1, "open_loop": False} | kind
    return Run(folder=Path("unread"), configuration=name, **given)


def test_runs_of_both_configurations_share_a_figure_and_others_do_not():
    runs = [run_of(name, slew=True) for name in CONFIGURATIONS]
    runs += [run_of(name, slew=False, open_loop=loop) for name in CONFIGURATIONS for loop in (False, True)]
    runs += [run_of("centralised", slew=True, seed=2), run_of("centralised", slew=True, variant=AS_PUBLISHED)]
    runs += [run_of("centralised", slew=True)]  # once more, as of another controller

    drawn = result_figures(runs)

    assert list(drawn) == ["slew-seed1", "fine-pointing-seed1", "slew-seed2", "slew-as-published-seed1", "slew-seed1-2"]
