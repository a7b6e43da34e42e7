"""filterpy's KalmanFilter and its smoother, without the rest of that package.

``import filterpy.kalman`` imports all of filterpy and most of scipy, for log-likelihoods and
filters that are not used here. That was two thirds of the computing time of a start of `serve`.
Only two files of filterpy are used, and they need numpy alone. This module runs them as they are
installed. A call for a log-likelihood still works, and imports the rest then.
"""

from __future__ import annotations

import importlib.util
import sys
from copy import copy
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

_ABOVE = ("filterpy.common", "filterpy.stats")  # the packages that kalman_filter.py imports from


def _log_density(*args: Any, **kwargs: Any) -> Any:
    from filterpy.stats import logpdf

    return logpdf(*args, **kwargs)


def _is_scalar(value: Any) -> bool:
    return not isinstance(value, np.ndarray) and bool(np.isscalar(value))


# filterpy calls these for arrays only. These give the same bits, and save 1.5 % of a flight's time.
_PLAINER = {"deepcopy": copy, "dot": np.ndarray.dot, "isscalar": _is_scalar}


def _folder() -> Path:
    spec = importlib.util.find_spec("filterpy")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("No module named 'filterpy'", name="filterpy")
    return Path(spec.origin).parent


def _run(name: str, path: Path) -> ModuleType:
    """Run a file as a module, without an entry in ``sys.modules``."""
    spec: ModuleSpec | None = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _load() -> ModuleType:
    """Load filterpy/kalman/kalman_filter.py with only filterpy/common/helpers.py of filterpy."""
    folder = _folder()
    helpers = _run(f"{__name__}.helpers", folder / "common" / "helpers.py")
    stats = ModuleType("filterpy.stats")
    stats.logpdf = _log_density  # type: ignore[attr-defined]
    before = {name: sys.modules.get(name) for name in _ABOVE}
    sys.modules.update(zip(_ABOVE, (helpers, stats), strict=True))
    try:
        filter_module = _run(f"{__name__}.kalman_filter", folder / "kalman" / "kalman_filter.py")
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
    vars(filter_module).update(_PLAINER)
    return filter_module


_FILTERPY = _load()
KalmanFilter: Any = _FILTERPY.KalmanFilter
rts_smoother: Any = _FILTERPY.rts_smoother
