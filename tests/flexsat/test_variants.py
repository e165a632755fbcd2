"""The variants: what chooses each, and that nothing but their module asks for the parameter by name."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from flexsat.variants import AS_PUBLISHED, CORRECTED, OF_DESIGN, PUBLISHED, VARIANTS, Variant, chosen_by

ROOT = Path(__file__).parents[2]
# the parameter by its name: the variants, a table of a spacecraft's file, messages and texts that users read, the
# names of columns in the paper's stored results, and the option of `flexsat paper` that chooses variants
NAMED = {
    "components/flexsat/variants.py",
    "components/flexsat/description/configuration.py",
    "components/flexsat/runtime/controller_parameters.py",
    "components/flexsat/fmu/documentation/controller_text.py",
    "orchestrator/flexbench/cli/paper.py",
    "orchestrator/flexbench/studies/paper/published.py",
}


@pytest.mark.parametrize(
    ("given", "design", "expected"),
    [
        ({}, None, CORRECTED),  # a record of an earlier version may set neither
        ({}, "robust", CORRECTED),
        ({"as_published": False}, "published", PUBLISHED),
        ({"as_published": True}, "robust", AS_PUBLISHED),
        ({"as_published": True}, "published", AS_PUBLISHED),
    ],
)
def test_parameters_choose_a_variant(given: dict[str, bool], design: str | None, expected: Variant):
    assert chosen_by(given.get, design) is expected


def test_a_variant_sets_what_chooses_it():
    for variant in VARIANTS:
        design = next((design for design, one in OF_DESIGN.items() if one == variant), None)
        assert chosen_by(variant.switch.get, design) is variant


def test_all_slips_are_those_of_the_release_alone():
    """PHYSICS section 7 has a row for each: one that the release shares with the others would be none."""
    slips = [item.name for item in fields(Variant) if item.name not in ("name", "label", "flown")]
    assert not [slip for slip in slips if getattr(AS_PUBLISHED, slip) == getattr(CORRECTED, slip)]
    assert not [slip for slip in slips if getattr(PUBLISHED, slip) != getattr(CORRECTED, slip)]


def test_the_parameter_is_named_in_few_files():
    """What is downstream takes a variant: a flag handed through the code again would be named in more files."""
    sources = [path for folder in ("components", "orchestrator") for path in (ROOT / folder).rglob("*.py")]
    found = {str(path.relative_to(ROOT)) for path in sources if re.search(r"\bas_published\b", path.read_text("utf-8"))}
    assert found == NAMED
