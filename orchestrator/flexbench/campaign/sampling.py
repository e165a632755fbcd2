"""Draw the inputs of all cases: random, Latin hypercube, Sobol, Saltelli, grid, one at a time, or from a table."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import scipy.stats

from flexsat.arrays import Array
from lockstep.errors import InputError, suggestion

from .campaign_file import MOST, Campaign, Input
from .distributions import Value
from .statistics.sensitivities import saltelli_points

Case = Mapping[str, Value]  # value by input, in the unit of the campaign file


def draw(campaign: Campaign) -> list[Case]:
    """Return the cases of a campaign, the first one first.

    Raises
    ------
    InputError
        If a table lacks a column, or correlations contradict each other.
    """
    inputs = campaign.inputs
    match campaign.sampling:
        case "table":
            assert campaign.table is not None
            return _of_table(campaign.table, inputs)
        case "grid":
            if np.prod([float(len(one.drawn.values)) for one in inputs]) > MOST:
                raise InputError(f"{campaign.path.name}: sampling = 'grid': more than {MOST} cases; give fewer values")
            lists = product(*(one.drawn.values for one in inputs))
            return [{one.name: value for one, value in zip(inputs, values, strict=True)} for values in lists]
        case "one-at-a-time":
            return _one_at_a_time(inputs)
    shares = correlated(_shares(campaign), inputs, campaign.correlations)
    columns = {one.name: one.drawn.at(shares[:, number]) for number, one in enumerate(inputs)}
    return [{name: column[k] for name, column in columns.items()} for k in range(len(shares))]


def _shares(campaign: Campaign) -> Array:
    """Return points in the unit cube, (cases, inputs)."""
    count, width = campaign.cases or 0, len(campaign.inputs)
    if not width:
        return np.empty((count, 0))
    if campaign.sampling == "random":
        return np.asarray(np.random.default_rng(campaign.seed).random((count, width)))
    if campaign.sampling == "saltelli":
        return saltelli_points(width, count, campaign.seed)
    engine: scipy.stats.qmc.QMCEngine
    if campaign.sampling == "sobol":
        engine = scipy.stats.qmc.Sobol(width, rng=np.random.default_rng(campaign.seed))
    else:
        engine = scipy.stats.qmc.LatinHypercube(width, rng=np.random.default_rng(campaign.seed))
    shares = np.asarray(engine.random(count), dtype=float)
    # Sobol points may be 0, where unbounded distributions are infinite
    return np.asarray(np.clip(shares, 2.0**-53, 1.0 - 2.0**-53))


def correlated(shares: Array, inputs: Sequence[Input], correlations: Mapping[tuple[str, str], float]) -> Array:
    """Return points whose normal scores have these correlations: a Gaussian copula. Each column keeps its distribution.

    Parameters
    ----------
    shares : (cases, inputs) in the unit cube
    correlations : by two names of inputs
    """
    if not correlations:
        return shares
    names = [one.name for one in inputs]
    chosen = [k for k, name in enumerate(names) if any(name in pair for pair in correlations)]
    matrix = np.eye(len(chosen))
    places = {names[k]: place for place, k in enumerate(chosen)}
    for (first, second), value in correlations.items():
        matrix[places[first], places[second]] = matrix[places[second], places[first]] = value
    try:
        lower = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise InputError(
            f"correlation: those of {', '.join(places)} contradict each other; make them smaller"
        ) from None
    found = shares.copy()
    found[:, chosen] = scipy.stats.norm.cdf(scipy.stats.norm.ppf(shares[:, chosen]) @ lower.T)
    return found


def _one_at_a_time(inputs: Sequence[Input]) -> list[Case]:
    nominal: dict[str, Value] = {one.name: one.drawn.nominal for one in inputs if one.drawn.nominal is not None}
    cases: list[Case] = [nominal]
    for one in inputs:
        cases += [{**nominal, one.name: value} for value in one.drawn.values if value != one.drawn.nominal]
    return cases


def _of_table(path: Path, inputs: Sequence[Input]) -> list[Case]:
    columns = _columns(path)
    for one in inputs:
        if one.name not in columns:
            raise InputError(f"{path}: {one.name}: no such column; there are {', '.join(columns)}"
                             f"{suggestion(one.name, list(columns))}")  # fmt: skip
    for name in columns:
        if name not in {one.name for one in inputs}:
            raise InputError(
                f"{path}: column {name}: has no [input.{name}] in the campaign file; remove it or add that"
            )
    count = len(next(iter(columns.values()), []))
    if not count:
        raise InputError(f"{path}: holds no case")
    return [{name: column[k] for name, column in columns.items()} for k in range(count)]


def _columns(path: Path) -> dict[str, list[Value]]:
    try:
        if path.suffix == ".parquet":
            return dict(pq.read_table(path).to_pydict())
        with path.open(newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path}: cannot be read ({error}); give a CSV or Parquet file with a column an input"
        ) from None
    header = [name.strip() for name in rows[0]] if rows else []
    if twice := [name for name in header if header.count(name) > 1]:
        raise InputError(f"{path}: column {twice[0]}: stands there twice; remove one of them")
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(header):
            raise InputError(f"{path}: line {number}: has {len(row)} values, and there are {len(header)} columns")
    return {name: [_plain(row[k]) for row in rows[1:]] for k, name in enumerate(header)}


def _plain(text: str) -> Value:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text.strip()
