"""The part of filterpy that navigation uses: the library's own, and the rest where it is asked for."""

from __future__ import annotations

import copy
import sys

import filterpy.kalman
import numpy as np
import pytest

from mission.navigation.kalman import KalmanFilter, rts_smoother


def test_the_filter_and_the_smoother_are_the_files_that_filterpy_installs() -> None:
    """The same files: so the same arithmetic, to the last bit."""
    theirs = filterpy.kalman.KalmanFilter
    for ours, whole in (
        (rts_smoother, filterpy.kalman.rts_smoother),
        (KalmanFilter.predict, theirs.predict),
        (KalmanFilter.update, theirs.update),
    ):
        assert ours is not whole
        assert ours.__code__ == whole.__code__  # the file's name is part of it


def test_whoever_imports_filterpy_itself_gets_the_whole_of_it() -> None:
    assert filterpy.stats.logpdf is sys.modules["filterpy.stats"].logpdf
    assert filterpy.common.Q_discrete_white_noise is not None


def test_a_log_likelihood_is_told_to_whoever_asks() -> None:
    kalman, whole = KalmanFilter(2, 1), filterpy.kalman.KalmanFilter(2, 1)
    for one in (kalman, whole):
        one.H = np.array([[1.0, 0.0]])
        one.predict()
        one.update(0.5)
    assert kalman.log_likelihood == pytest.approx(whole.log_likelihood, abs=0.0)
    assert copy.deepcopy(kalman).x.tolist() == whole.x.tolist()
