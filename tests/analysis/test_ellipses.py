"""Laws of the ellipses on every plan: where the doubt is, as large as it is, and never in the way."""

from __future__ import annotations

import math

import pytest
from later import Later

from mission.analysis.ellipses import LARGEST, draw_ellipses, ellipse, width_of

drawing, patches = Later("matplotlib.figure"), Later("matplotlib.patches")


def test_the_ellipse_of_equal_sigmas_is_a_circle_of_the_95_percent_radius() -> None:
    along, across, _ = ellipse((4.0, 0.0, 4.0))
    assert along == across == pytest.approx(2 * 2.0 * 2.4477, rel=1e-4)


@pytest.mark.parametrize(
    ("covariance", "bearing"),
    [((9.0, 0.0, 1.0), 0.0), ((1.0, 0.0, 9.0), 90.0), ((5.0, 4.0, 5.0), 45.0)],
)
def test_the_ellipse_points_where_the_doubt_is(
    covariance: tuple[float, float, float], bearing: float
) -> None:
    along, across, found = ellipse(covariance)
    assert along == pytest.approx(3.0 * across)
    assert math.degrees(found) == pytest.approx(bearing)


@pytest.mark.proof
def test_an_ellipse_lies_on_the_picture_as_it_lies_on_the_sea() -> None:
    axes = drawing.Figure().subplots()
    draw_ellipses(axes, [(3.0, 2.0, (5.0, 4.0, 5.0))], 100.0, "k")
    (drawn,) = [patch for patch in axes.patches if isinstance(patch, patches.Ellipse)]
    assert drawn.get_center() == (3.0, 2.0)
    assert drawn.angle == pytest.approx(45.0)  # of east: north-east is half way
    assert drawn.width == pytest.approx(3.0 * drawn.height)


def test_an_ellipse_that_would_bury_the_track_is_left_out_and_none_widens_the_frame() -> None:
    axes = drawing.Figure().subplots()
    axes.plot([0.0, 100.0], [0.0, 10.0])
    frame = axes.get_xlim(), axes.get_ylim()
    sigma = LARGEST * 100.0 / ellipse((1.0, 0.0, 1.0))[0]
    fits, buries = ((0.99 * sigma) ** 2, 0.0, 1.0), ((1.01 * sigma) ** 2, 0.0, 1.0)
    draw_ellipses(axes, [(50.0, 5.0, fits), (50.0, 5.0, buries), (math.nan, 0.0, fits)], 100.0, "k")
    assert len(axes.patches) == 1
    assert (axes.get_xlim(), axes.get_ylim()) == frame
    said = [text.get_text() for text in axes.legend().get_texts()]
    assert said == ["95 % ellipses, larger ones left out"]


def test_the_legend_says_where_every_ellipse_would_bury_the_track_and_where_none_would() -> None:
    for sigma2, words in ((1.0, "95 % ellipses"), (1e6, "95 % ellipses, left out: larger than")):
        axes = drawing.Figure().subplots()
        draw_ellipses(axes, [(50.0, 5.0, (sigma2, 0.0, sigma2))], 100.0, "k")
        (said,) = (text.get_text() for text in axes.legend().get_texts())
        assert said.startswith(words)
        assert ("left out" in said) == (len(axes.patches) == 0)


def test_ellipses_that_lie_on_one_another_are_drawn_once() -> None:
    axes = drawing.Figure().subplots()
    size = ellipse((1.0, 0.0, 1.0))[0]
    places = [(east * size, 0.0, (1.0, 0.0, 1.0)) for east in (0.0, 0.5, 0.99, 1.01, 1.5, 2.02)]
    draw_ellipses(axes, places, 100.0, "k")
    centres = [patch.get_center()[0] / size for patch in axes.patches]
    assert centres == pytest.approx([0.0, 1.01, 2.02])


def test_the_width_of_a_frame_is_its_long_side_whatever_is_not_known() -> None:
    assert width_of([(0.0, 0.0), (3.0, -7.0), (math.nan, 900.0)]) == 7.0
    assert width_of([]) == 0.0
