"""The part of filterpy that navigation uses: the library's own, and the rest where it is asked for."""

from __future__ import annotations

import copy
import sys

import numpy as np
import pytest
from later import Later

from mission.navigation.kalman import KalmanFilter, rts_smoother

whole = Later("filterpy.kalman")


@pytest.mark.proof
def test_the_filter_and_the_smoother_are_the_files_that_filterpy_installs() -> None:
    """The same files: so the same arithmetic, to the last bit."""
    theirs = whole.KalmanFilter
    for ours, other in (
        (rts_smoother, whole.rts_smoother),
        (KalmanFilter.predict, theirs.predict),
        (KalmanFilter.update, theirs.update),
    ):
        assert ours is not other
        assert ours.__code__ == other.__code__  # the file's name is part of it


def test_whoever_imports_filterpy_itself_gets_the_whole_of_it() -> None:
    assert whole.EKF.logpdf is sys.modules["filterpy.stats"].logpdf
    assert {"Q_discrete_white_noise", "Saver"} <= set(vars(sys.modules["filterpy.common"]))


def test_a_log_likelihood_is_told_to_whoever_asks() -> None:
    ours, theirs = KalmanFilter(2, 1), whole.KalmanFilter(2, 1)
    for one in (ours, theirs):
        one.H = np.array([[1.0, 0.0]])
        one.predict()
        one.update(0.5)
    assert ours.log_likelihood == pytest.approx(theirs.log_likelihood, abs=0.0)
    assert copy.deepcopy(ours).x.tolist() == theirs.x.tolist()
