"""Run a component so that its results are the same bits on every processor.

The steps of a component multiply matrices with BLAS, whose sums depend on the processor. For reference results, which
travel in the FMU, the arrays of the component are replaced by ones that multiply in a fixed order. Apart from rounding
the results are the same.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

AnyArray = NDArray[Any]

# sums over the last axis of the first and the first or last but one of the second factor, by their numbers of axes
_SUMS = {True: {True: "j,j->", False: "j,...jk->...k"}, False: {True: "...ij,j->...i", False: "...ij,...jk->...ik"}}
_ELEMENTARY = (np.sin, np.cos)  # the last digit depends on the processor's vector instructions


class FixedOrderArray(np.ndarray[Any, Any]):
    """An array whose products, and those of all that is computed from it, are summed without BLAS."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, out: Any = (), **options: Any) -> Any:
        """Compute with plain arrays, and return arrays of this class."""
        given = [_plain(value) for value in inputs]
        if method == "__call__" and ufunc is np.matmul:
            result = _product(*given)
        elif method == "__call__" and ufunc in _ELEMENTARY:
            result = np.asarray(ufunc(np.asarray(given[0], np.longdouble)), np.float64)
        else:
            if out:
                options["out"] = tuple(_plain(target) for target in out)
            result = getattr(ufunc, method)(*given, **options)
            return out[0] if out else _wrapped(result)
        if out:
            _plain(out[0])[...] = result
            return out[0]
        return _wrapped(result)

    def dot(self, b: Any, out: Any = None) -> Any:
        """Multiply as `@`; of `numpy.ndarray`, the method that steps call as it takes the least time."""
        return np.matmul(self, b) if out is None else np.matmul(self, b, out=out)


def use_fixed_order(slave: Any) -> None:
    """Let a component, just instantiated, compute in a fixed order: what it prepares, and its ports."""
    view = slave.view
    slave.view = lambda name: view(name).view(FixedOrderArray)
    slave.in_use, slave.fixed_order = _in_fixed_order, True


def _in_fixed_order(prepared: Any) -> Any:
    """Return a frozen dataclass with all its arrays, and those of dataclasses inside, as `FixedOrderArray`."""
    changed = {}
    for item in fields(prepared):
        value = getattr(prepared, item.name)
        if isinstance(value, np.ndarray):
            changed[item.name] = value.view(FixedOrderArray)
        elif is_dataclass(value):
            changed[item.name] = _in_fixed_order(value)
    return replace(prepared, **changed)


def _plain(value: Any) -> Any:
    return value.view(np.ndarray) if isinstance(value, FixedOrderArray) else value


def _wrapped(result: Any) -> Any:
    return result.view(FixedOrderArray) if isinstance(result, np.ndarray) else result


def _product(a: AnyArray, b: AnyArray) -> Any:
    a, b = np.ascontiguousarray(a), np.ascontiguousarray(b)
    return np.einsum(_SUMS[a.ndim == 1][b.ndim == 1], a, b, optimize=False)
