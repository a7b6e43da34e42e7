"""Polygons against shapely, and by their own laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely.geometry import LineString, MultiPoint, Point, Polygon

from mission.navigation.distribution import PLANE_95
from mission.navigation.polygons import (
    between,
    edges,
    fault,
    gap,
    hull,
    inside,
    sigmas,
    signed_area,
    to_edge,
)

metres = st.integers(-500, 500).map(float)
points = st.tuples(metres, metres)
corners = st.lists(points, min_size=3, max_size=9)
SQUARE = ((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0))
ROUND = (1.0, 0.0, 1.0)


def shape(polygon: list[tuple[float, float]]) -> Polygon:
    made = Polygon(polygon)
    assume(made.is_valid and made.area >= 1.0)
    return made


@given(corners)
def test_what_is_a_polygon_is_one_to_shapely(polygon) -> None:
    made = Polygon(polygon)
    distinct = all(math.dist(a, b) > 0.0 for a, b in edges(polygon))
    assert (fault(polygon) == "") == (made.is_valid and made.area >= 1.0 and distinct)


@pytest.mark.proof
@given(corners, points)
def test_inside_and_the_distance_to_the_edge_are_those_of_shapely(polygon, point) -> None:
    made = shape(polygon)
    assert inside(polygon, point) == made.covers(Point(point))
    assert to_edge(polygon, point) == pytest.approx(made.exterior.distance(Point(point)), abs=1e-9)


@pytest.mark.proof
@given(corners)
def test_either_way_round_is_the_same_area(polygon) -> None:
    made = shape(polygon)
    assert abs(signed_area(polygon)) == pytest.approx(made.area)
    assert signed_area(polygon) == pytest.approx(-signed_area(polygon[::-1]))


@given(points, points, points, points)
def test_two_segments_are_as_far_apart_as_shapely_says(a, b, c, d) -> None:
    assume(a != b and c != d)
    far = LineString([a, b]).distance(LineString([c, d]))
    assert between((a, b), (c, d)) == pytest.approx(far, abs=1e-9)


@pytest.mark.proof
@given(st.lists(points, min_size=1, max_size=12), corners)
def test_a_hull_is_as_far_from_the_edge_as_shapely_says(cloud, polygon) -> None:
    made = shape(polygon)
    body = hull(cloud)
    whole = MultiPoint(cloud).convex_hull
    outline = whole.exterior if whole.geom_type == "Polygon" else whole
    assert gap(body, polygon) == pytest.approx(outline.distance(made.exterior), abs=1e-9)
    assert {tuple(p) for p in body} <= {tuple(p) for p in cloud}


@pytest.mark.parametrize(
    ("polygon", "why"),
    [
        (SQUARE[:2], "three corners"),
        (((0.0, 0.0), (0.0, 0.0), (10.0, 10.0)), "corners 1 and 2 are the same place"),
        (((0.0, 0.0), (10.0, 10.0), (10.0, 0.0), (0.0, 10.0)), "its edges cross"),
        (((0.0, 0.0), (0.0, 0.5), (0.5, 0.0)), "less than 1"),
        (((0.0, 0.0), (10.0, 0.0), (5.0, 0.0)), "cross"),
    ],
)
def test_what_is_no_area_is_told_why(polygon, why) -> None:
    assert why in fault(polygon)


def test_the_edge_is_as_many_sigmas_away_as_the_ellipse_is_thin() -> None:
    assert sigmas(SQUARE, (5.0, -3.0), ROUND) == pytest.approx(3.0)
    assert sigmas(SQUARE, (5.0, -3.0), (100.0, 0.0, 1.0)) == pytest.approx(3.0)
    assert sigmas(SQUARE, (5.0, -3.0), (1.0, 0.0, 9.0)) == pytest.approx(1.0)


def test_an_ellipse_that_leans_reaches_the_edge_where_it_leans_to() -> None:
    """By brute force: the least Mahalanobis distance over the edge's points."""
    covariance = (9.0, 5.0, 4.0)
    inverse = np.linalg.inv(np.array([[9.0, 5.0], [5.0, 4.0]]))
    here = (-4.0, -1.0)
    ring = [LineString([*SQUARE, SQUARE[0]]).interpolate(s / 100) for s in range(4001)]
    offsets = (np.array([p.x - here[0], p.y - here[1]]) for p in ring)
    least = min(math.sqrt(v @ inverse @ v) for v in offsets)
    assert sigmas(SQUARE, here, covariance) == pytest.approx(least, rel=1e-3)


@pytest.mark.parametrize("covariance", [(0.0, 0.0, 0.0), (0.0, 0.0, 4.0), (4.0, 0.0, 0.0)])
def test_a_place_that_is_certain_in_a_direction_has_a_distance_all_the_same(covariance) -> None:
    assert sigmas(SQUARE, (5.0, -30.0), covariance) > PLANE_95
    assert sigmas(SQUARE, (0.0, 5.0), covariance) == 0.0
