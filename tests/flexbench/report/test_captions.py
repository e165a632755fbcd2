"""Every figure that is drawn has a caption of its own."""

from flexbench.figures.figure_lists import design_figures
from flexbench.report.captions import caption_of, place_of
from flexsat.variants import AS_PUBLISHED


def test_every_figure_of_a_design_has_a_caption(built):
    names = [*design_figures(built), *design_figures(built, AS_PUBLISHED)]

    for name in names:
        assert caption_of(name) != name.replace("-", " ")
    assert "distributed" in caption_of("wheel-responses-distributed-as-published")


def test_figures_of_runs_name_variant_and_seed():
    assert caption_of("slew-as-published-seed3").startswith("The slew as published, seed 3:")
    assert caption_of("fine-pointing-seed12-2").startswith("Fine pointing, seed 12:")
    assert caption_of("a_figure-of-others") == "a figure of others"


def test_what_flew_stands_first_and_the_bench_last(built):
    names = [*design_figures(built), "slew-as-published-seed1", "slew-seed1", "nichols-centralised", "other"]

    ordered = sorted(names, key=place_of)
    assert ordered[:3] == ["slew-seed1", "slew-as-published-seed1", "nichols-centralised"]
    assert ordered[3] == "structure"
    assert ordered[-2:] == ["software", "other"]
