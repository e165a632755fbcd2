"""Spectra of a run: densities by Welch's method with their confidence, and cumulative spectra."""

from .channels import CHANNELS, RunSpectra, run_spectra
from .welch import Method, Spectrum, estimate

__all__ = ["CHANNELS", "Method", "RunSpectra", "Spectrum", "estimate", "run_spectra"]
