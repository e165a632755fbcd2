"""Covariances of the settled loop, and the cancellation of harmonic jitter that is designed on them."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.studies.margins.real_plant import Plants
from flexbench.studies.spillover.stationary import products_of_moduli, stationary
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import build_design
from flexsat.parameters import ARCSECOND, PUBLISHED_MODES
from flexsat.spacecraft.variation import ModelErrors, with_modes

# PHYSICS section 7, mesh of record, corrected: pointing [arcsec], torque [N.m], deformation [um], means of 4 to 6 runs
SIMULATED = {"centralised": (0.123, 0.093, 0.160), "distributed": (0.064, 0.50, 0.104)}
# issue of the robust controller: pointing, torque, deformation; the last of the centralised layout cannot be reached
REQUIRED = {"centralised": (0.02, 0.02, 0.125), "distributed": (0.03, 0.06, 0.14)}


def in_units(found):
    return found.pointing / ARCSECOND, found.torque, 1e6 * found.deformation


def settled(plants, modes, **which):
    return in_units(stationary(plants.design, plants.model(modes, ModelErrors()), plants.spacecraft.mass, **which))


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_covariances_agree_with_simulated_runs(name):
    # the published design on its own modes, at the wheel speeds chosen on them
    config = with_modes(configuration(name, "published"), PUBLISHED_MODES)
    # a third: what few runs with random wheel phases scatter by
    assert_allclose(settled(Plants(build_design(config), PUBLISHED_MODES), PUBLISHED_MODES), SIMULATED[name], rtol=0.35)


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_robust_design_meets_its_requirements(robust, name):
    assert np.all(np.array(settled(robust[name], 60)) <= REQUIRED[name])


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_coarse_pointing_of_the_robust_design(robust, name):
    pointing, _, _ = settled(robust[name], 40, fine=False, jitter=False)
    assert pointing <= 1.0  # arcsec


def test_cancelled_jitter_deforms_less_and_costs_nothing_else(robust):
    """Without the cancellation the distributed structure deforms as in open loop; the feedback's share is untouched."""
    plants = robust["distributed"]
    without = replace(plants.design.controller, jitter_torque=np.zeros_like(plants.design.controller.jitter_torque))
    design = replace(plants.design, controller=without)
    plant, mass = plants.model(60, ModelErrors()), plants.spacecraft.mass
    pointing, _, deformation = in_units(stationary(design, plant, mass))
    better = settled(plants, 60)
    assert better[2] < 0.6 * deformation
    assert_allclose(better[0], pointing, rtol=0.01)  # harmonics are far above what the attitude follows


def test_the_mean_product_of_moduli_is_that_of_draws():
    covariance = np.array([[1.0, -1.0, 0.3], [-1.0, 4.0, 0.0], [0.3, 0.0, 0.25]])
    drawn = np.abs(np.random.default_rng(1).multivariate_normal(np.zeros(3), covariance, 200_000))
    expected = drawn.T @ drawn / len(drawn)
    # five deviations of the mean of 200,000 products, each of a deviation of up to twice its mean
    assert products_of_moduli(covariance) == pytest.approx(expected, rel=0.02)
    assert products_of_moduli(covariance).diagonal() == pytest.approx(covariance.diagonal(), rel=1e-12)
