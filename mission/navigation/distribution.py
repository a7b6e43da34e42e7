"""Probabilities of normal distributions, for ``sure 95%`` and the radius limit.

one variable      Phi((b - mu) / sigma)
a distance        P(|x| <= r) for x ~ N(mu, P) in the plane: Phi across one principal axis,
                  integrated along the other (Gauss-Legendre, 24 points a panel; to 1e-4 for any
                  ellipse that is not thinner than 1 : 100)
"""

from __future__ import annotations

import itertools
import math

Covariance = tuple[float, float, float]  # nn, ne, ee in m^2

PLANE_95 = math.sqrt(-2.0 * math.log(0.05))  # sigmas: holds 95 % of a circular distribution
_EIGHT_SIGMA = 8.0


def below(bound: float, mean: float, sigma: float) -> float:
    """P(x <= bound). With a sigma of 0 the mean is certain."""
    if sigma <= 0.0:
        return 1.0 if mean <= bound else 0.0
    return 0.5 * math.erfc((mean - bound) / (sigma * math.sqrt(2.0)))


def principal(covariance: Covariance) -> tuple[float, float, float]:
    """Greatest and smallest sigma, and the direction of the greatest (rad from north)."""
    nn, ne, ee = covariance
    middle, half = 0.5 * (nn + ee), math.hypot(0.5 * (nn - ee), ne)
    return (
        math.sqrt(max(middle + half, 0.0)),
        math.sqrt(max(middle - half, 0.0)),
        0.5 * math.atan2(2.0 * ne, nn - ee),
    )


def of_principal(great: float, small: float, direction: float) -> Covariance:
    """Return the covariance with these axes: the inverse of ``principal``."""
    c, s = math.cos(direction), math.sin(direction)
    nn, ee = (great * c) ** 2 + (small * s) ** 2, (great * s) ** 2 + (small * c) ** 2
    return nn, (great**2 - small**2) * c * s, ee


def around_95(covariance: Covariance) -> float:
    """Return the radius (m) of the circle around the 95 % ellipse: the variable ``uncertainty``."""
    return PLANE_95 * principal(covariance)[0]


def radius_95(covariance: Covariance) -> float:
    """Return the radius (m) about the mean that holds 95 %: a cubic in the ratio of the axes, exact
    to 0.2 %."""
    great, small, _ = principal(covariance)
    q = small / great if great > 0.0 else 0.0
    return great * (1.9608 + q * (0.0041 + q * (0.1143 + q * 0.3716)))


def along(covariance: Covariance, bearing: float) -> float:
    """Return the sigma in direction ``bearing`` (rad from north)."""
    nn, ne, ee = covariance
    c, s = math.cos(bearing), math.sin(bearing)
    return math.sqrt(max(nn * c * c + 2.0 * ne * c * s + ee * s * s, 0.0))


def within(radius: float, north: float, east: float, covariance: Covariance) -> float:
    """P(distance from the origin <= radius) for a position at (north, east)."""
    if radius < 0.0:
        return 0.0
    great, small, direction = principal(covariance)
    far = math.hypot(north, east)
    if great <= 0.0:
        return 1.0 if far <= radius else 0.0
    if far + _EIGHT_SIGMA * great <= radius:
        return 1.0
    if radius <= 0.0 or far - _EIGHT_SIGMA * great >= radius:
        return 0.0
    c, s = math.cos(direction), math.sin(direction)
    return _integral(radius, north * c + east * s, east * c - north * s, great, small)


def _integral(radius: float, u: float, v: float, great: float, small: float) -> float:
    low = max(-radius, u - _EIGHT_SIGMA * great)
    high = min(radius, u + _EIGHT_SIGMA * great)
    ends = [low, *(x for x in _steep(radius, v, small) if low < x < high), high]
    total = 0.0
    for start, end in itertools.pairwise(ends):
        # in the angle x = radius sin(a) the ends of the disc are smooth
        first, last = math.asin(start / radius), math.asin(end / radius)
        middle, half = 0.5 * (first + last), 0.5 * (last - first)
        for node, weight in _LEGENDRE:
            angle = middle + half * node
            x, chord = radius * math.sin(angle), radius * math.cos(angle)
            density = math.exp(-0.5 * ((x - u) / great) ** 2) / (great * math.sqrt(2.0 * math.pi))
            across = below(chord, v, small) - below(-chord, v, small)
            total += weight * half * density * across * chord
    return min(max(total, 0.0), 1.0)


def _steep(radius: float, v: float, small: float) -> list[float]:
    """Return the ends of panels: around where the disc's edge passes the narrow axis's mean."""
    if abs(v) >= radius:
        return []
    x = math.sqrt(radius * radius - v * v)
    width = min(_EIGHT_SIGMA * small * abs(v) / max(x, 1e-9), x)
    return sorted({-x - width, -x, -x + width, x - width, x, x + width, 0.0})


def _legendre(n: int) -> tuple[tuple[float, float], ...]:
    """Nodes and weights by Newton's method on the recurrence (Abramowitz and Stegun 25.4.29)."""
    rows = []
    for i in range(n):
        x = math.cos(math.pi * (i + 0.75) / (n + 0.5))
        for _ in range(100):
            p0, p1 = 1.0, x
            for k in range(2, n + 1):
                p0, p1 = p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / k
            slope = n * (x * p1 - p0) / (x * x - 1.0)
            step = p1 / slope
            x -= step
            if abs(step) < 1e-15:
                break
        rows.append((x, 2.0 / ((1.0 - x * x) * slope * slope)))
    return tuple(rows)


_LEGENDRE = _legendre(24)
