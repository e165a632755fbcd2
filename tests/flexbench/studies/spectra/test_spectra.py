"""Spectra against closed forms: sines, white and band-limited noise, Parseval, and the coverage of the bounds."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.figures.spectra import density_unit, spectra_figure, thinned
from flexbench.studies.spectra import CHANNELS, RunSpectra, estimate
from flexbench.studies.spectra.channels import channel_history
from flexbench.studies.spectra.welch import cumulative_spectrum, degrees_of_freedom, noise_bandwidth
from flexsat.design.chain import build_designs
from lockstep import InputError, Signals

INTERVAL = 0.005


def test_white_noise_has_the_density_of_its_variance():
    noise = 2.0 * np.random.default_rng(1).standard_normal(400_000)
    spectrum = estimate(noise, INTERVAL, 0.5)
    flat = 2.0 * 4.0 * INTERVAL  # one-sided: variance over half the sampling frequency
    inside = slice(2, -2)
    # 1300 segments: 2 % a line, less their mean over a thousand lines
    assert_allclose(spectrum.total[inside].mean(), flat, rtol=5e-3)
    assert_allclose(spectrum.total[inside], flat, rtol=0.2)


def test_band_limited_noise_shows_its_density_and_its_band():
    rng, rows = np.random.default_rng(2), 400_000
    frequency = np.fft.rfftfreq(rows, INTERVAL)
    band = (frequency >= 5.0) & (frequency <= 8.0)
    level = 0.25  # units^2/Hz
    # the expected power of a line, level / duration, shared by its two halves
    size = np.sqrt(level / (rows * INTERVAL)) * rows / 2.0
    lines = size * band * (rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency)))
    spectrum = estimate(np.fft.irfft(lines, rows), INTERVAL, 0.1)

    inside = (spectrum.frequency > 5.5) & (spectrum.frequency < 7.5)
    outside = (spectrum.frequency < 4.0) | (spectrum.frequency > 9.0)
    assert_allclose(spectrum.total[inside].mean(), level, rtol=0.05)  # 2000 s x 2 Hz: 1 / sqrt(4000), three times
    assert spectrum.total[outside].max() < 1e-4 * level  # side lobes of the window
    steps, cumulative = spectrum.cumulative_frequency, spectrum.cumulative
    assert cumulative[steps < 4.9][-1] < 1e-9
    assert_allclose(cumulative[-1], 3.0 * level, rtol=0.05)


def test_sine_keeps_its_power_and_its_frequency():
    time = np.arange(40_000) * INTERVAL
    spectrum = estimate(3.0 * np.sin(2.0 * np.pi * 7.0 * time), INTERVAL, 0.1)
    step = spectrum.frequency[1]
    near = np.abs(spectrum.frequency - 7.0) < 0.5
    assert_allclose(spectrum.frequency[np.argmax(spectrum.total)], 7.0, atol=step)
    assert_allclose(spectrum.total[near].sum() * step, 4.5, rtol=1e-3)  # leakage of a Hann window beyond 0.5 Hz
    steps, cumulative = spectrum.cumulative_frequency, spectrum.cumulative
    assert cumulative[steps < 6.99][-1] < 1e-12
    assert_allclose(cumulative[steps > 7.01][0], 4.5, rtol=1e-12)  # whole periods: one line


@pytest.mark.parametrize("rows", [1000, 1001])
def test_parseval_the_cumulative_spectrum_ends_at_the_mean_square(rows: int):
    history = np.random.default_rng(3).standard_normal((rows, 3)) + np.array([1.0, -2.0, 0.0])
    steps, cumulative = cumulative_spectrum(history, INTERVAL)
    assert_allclose(cumulative[-1], np.mean(np.sum(history**2, axis=1)), rtol=1e-12)
    assert_allclose(cumulative[0], np.sum(history.mean(axis=0) ** 2), rtol=1e-12)
    assert np.all(np.diff(cumulative) >= 0.0)
    assert steps[0] == 0.0


def test_parseval_the_density_of_one_plain_segment_integrates_to_the_variance():
    history = np.random.default_rng(4).standard_normal(2000) + 5.0
    spectrum = estimate(history, INTERVAL, 1.0 / (2000 * INTERVAL), window="boxcar")
    assert spectrum.method.segments == 1
    assert_allclose(spectrum.total.sum() * spectrum.frequency[1], np.var(history), rtol=1e-12)
    assert_allclose(spectrum.mean_square, np.mean(history**2), rtol=1e-12)


def test_bounds_cover_the_true_density_with_their_confidence():
    """Each line of 200 histories of white noise, neighbours of correlated lines left out."""
    rng, true, hits, tries = np.random.default_rng(5), 2.0 * INTERVAL, 0, 0
    for _ in range(200):
        spectrum = estimate(rng.standard_normal(6000), INTERVAL, 0.5, level=0.95)
        low, high = spectrum.method.bounds()
        lines = spectrum.total[5:-5:5]
        hits += int(np.count_nonzero((low * lines <= true) & (true <= high * lines)))
        tries += len(lines)
    assert spectrum.method.segments > 5
    # 95 % of about 11000 lines, known to 0.2 %; the equivalent degrees of freedom are themselves an approximation
    assert_allclose(hits / tries, 0.95, atol=0.01)


def test_overlap_reduces_the_degrees_of_freedom():
    assert degrees_of_freedom("hann", 1000, 0, 10) == 20.0
    # a Hann window half on: (1/6)^2 of the power (Percival and Walden); 19 segments of half overlap
    expected = 38.0 / (1.0 + 2.0 * (18.0 / 19.0) / 36.0)
    assert_allclose(degrees_of_freedom("hann", 1000, 500, 19), expected, rtol=1e-3)
    assert degrees_of_freedom("boxcar", 1000, 500, 19) < degrees_of_freedom("hann", 1000, 500, 19)
    assert_allclose(noise_bandwidth("hann"), 1.5, rtol=1e-9)


@pytest.mark.parametrize(
    ("resolution", "message"),
    [(0.0, "resolution 0.0"), (0.001, "simulate longer"), (100.0, "too coarse")],
)
def test_bad_resolution_is_refused(resolution: float, message: str):
    with pytest.raises(InputError, match=message):
        estimate(np.zeros(1000), INTERVAL, resolution)


def test_the_deformation_of_modes_has_the_mean_square_of_the_norm():
    rng = np.random.default_rng(6)
    eta, mass = rng.standard_normal((500, 4)), 7.0
    columns = {f"plant.modal.displacement[{i + 1}]": eta[:, i] for i in range(4)}
    signals = Signals(time=np.arange(500) * INTERVAL, columns=columns, units={}, descriptions={})
    spectrum = estimate(channel_history(signals, "deformation", mass), INTERVAL, 5.0)
    norm = np.sqrt(np.sum(eta**2, axis=1) / mass)  # as the plant computes rms_deformation
    assert_allclose(spectrum.mean_square, np.mean(norm**2), rtol=1e-12)


def test_thinning_loses_no_peak_on_a_logarithmic_axis():
    frequency = np.arange(1, 20_001) * 0.005
    values = np.ones(20_000)
    values[[3, 12_345]] = 50.0, 1e-6
    short, kept = thinned(frequency, values)
    assert len(kept) <= 520
    assert (kept.max(), kept.min()) == (50.0, 1e-6)
    assert np.all(np.diff(short) > 0.0)


def test_figure_draws_four_quantities_with_units_bounds_and_their_rms():
    rng = np.random.default_rng(7)
    spectra = {
        channel.name: estimate(
            channel.display_scale * rng.standard_normal((4000, max(1, len(channel.components)))), INTERVAL, 0.5
        )
        for channel in CHANNELS
    }
    result = RunSpectra(start=150.0, duration=20.0, spectra=spectra)
    figure = spectra_figure(result, build_designs("centralised").corrected)
    assert len(figure.axes) == 2 * len(CHANNELS)
    for channel, left, right in zip(CHANNELS, figure.axes[::2], figure.axes[1::2], strict=True):
        assert left.get_ylabel() == f"density [{density_unit(channel.display_unit)}]"
        labels = [line.get_label() for line in left.get_lines()]
        assert labels == [*channel.components, "sum"]
        (total,) = (line for line in left.get_lines() if line.get_label() == "sum")
        expected = 2.0 * INTERVAL * max(1, len(channel.components))
        assert_allclose(np.median(total.get_ydata()), expected, rtol=0.3)
        band = left.collections[0].get_paths()[0].vertices[:, 1]
        assert band.max() > total.get_ydata().max()
        rms = np.sqrt(spectra[channel.name].mean_square) / channel.display_scale
        assert_allclose(right.get_lines()[0].get_ydata()[-1], rms, rtol=1e-9)
    assert "95 % bounds" in figure.get_suptitle()
