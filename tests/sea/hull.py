"""A rigid body in water: six degrees of freedom, any attitude.

The hull is REMUS 100 after T. Prestero, "Verification of a Six-Degree of Freedom Simulation Model for
the REMUS Autonomous Underwater Vehicle", MIT/WHOI 2001: vehicle parameters, added mass and the tables
of combined non-linear coefficients; the equations of motion are those of T. I. Fossen, "Handbook of
Marine Craft Hydrodynamics and Motion Control", 2nd ed., eq. 2.1 and 6.34, with the attitude as a unit
quaternion (section 2.2.2), for this vehicle may turn over.

Axes: x ahead, y starboard, z down; angles in rad, forces in N, moments in N m.

What differs from the paper, for the vehicle is no torpedo but a frame with five thruster pods: axial
drag times 10, linear damping of roll, pods at the stern that make it stable on its course, and the
weight hangs lower (`BALLAST`), as an open frame's does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

WEIGHT = 299.0  # N (Prestero, vehicle parameters)
MASS = WEIGHT / 9.81  # kg
BALLAST = 0.06  # m, centre of gravity below the centre of buoyancy (Prestero: 0.0196)
IXX, IYY, IZZ = 0.177, 3.45, 3.45  # kg m2
X_UDOT, Y_VDOT, Z_WDOT = -0.93, -35.5, -35.5  # added mass, kg
K_PDOT, M_QDOT, N_RDOT = -0.0704, -4.88, -4.88  # added inertia, kg m2
X_UU, Y_VV, Z_WW = -16.2, -131.0, -131.0  # kg/m; Prestero: -1.62, -1310 (a misprint), -131
K_PP, M_QQ, N_RR = -0.13, -188.0, -94.0  # kg m2
K_P = -1.2  # N m s, roll damping of the pods
Y_UV, Z_UW = -28.6, -28.6  # body and fin lift
M_UW, N_UV = -6.0, 6.0  # the same and the Munk moment; Prestero: 24, -24
M_UQ, N_UR, Y_UR, Z_UQ = -2.0, -2.0, 5.22, -5.22
RADIUS = 0.095  # m, half the hull's diameter

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Load:
    """What acts on the hull besides the water: forces and moments in body axes, and its trim."""

    force: Vector = (0.0, 0.0, 0.0)
    moment: Vector = (0.0, 0.0, 0.0)
    buoyancy: float = 8.0  # N, net and upward, when it is fully under water
    ballast: float = BALLAST  # m
    current: Vector = (0.0, 0.0, 0.0)  # m/s north, east, down


@dataclass
class Pose:
    """State: place (m north, east, down), attitude (quaternion), velocities through the water."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.09
    q: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    v: Vector = (0.0, 0.0, 0.0)
    w: Vector = (0.0, 0.0, 0.0)

    def vector(self) -> list[float]:
        """The 13 numbers that the integrator moves."""
        return [self.x, self.y, self.z, *self.q, *self.v, *self.w]


def rotation(q: tuple[float, ...]) -> tuple[Vector, Vector, Vector]:
    """Rows of the matrix that turns body axes into north, east, down (Fossen eq. 2.72)."""
    n, a, b, c = q
    return (
        (1 - 2 * (b * b + c * c), 2 * (a * b - c * n), 2 * (a * c + b * n)),
        (2 * (a * b + c * n), 1 - 2 * (a * a + c * c), 2 * (b * c - a * n)),
        (2 * (a * c - b * n), 2 * (b * c + a * n), 1 - 2 * (a * a + b * b)),
    )


def quaternion(yaw: float) -> tuple[float, float, float, float]:
    """Upright, with the bow at `yaw` rad clockwise from north."""
    return (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))


def _rates(s: list[float], load: Load) -> list[float]:
    """Time derivative of the 13 numbers."""
    z, n, a, b, c, u, v, w, p, q, r = s[2:]
    r0, r1, r2 = rotation((n, a, b, c))
    wet = min(1.0, max(0.0, (z + RADIUS) / (2 * RADIUS)))
    lift = (WEIGHT + load.buoyancy) * wet
    net = WEIGHT - lift  # N, downward
    m_u, m_v, m_w = MASS - X_UDOT, MASS - Y_VDOT, MASS - Z_WDOT
    i_p, i_q, i_r = IXX - K_PDOT, IYY - M_QDOT, IZZ - N_RDOT
    fx, fy, fz = load.force
    fx += net * r2[0] + X_UU * u * abs(u) - m_w * w * q + m_v * v * r
    fy += net * r2[1] + Y_VV * v * abs(v) + Y_UV * u * v + Y_UR * u * r + m_w * w * p - m_u * u * r
    fz += net * r2[2] + Z_WW * w * abs(w) + Z_UW * u * w + Z_UQ * u * q - m_v * v * p + m_u * u * q
    arm = load.ballast * WEIGHT
    k, m, o = load.moment
    k += K_PP * p * abs(p) + K_P * p - arm * r2[1] - (i_r - i_q) * q * r
    m += M_QQ * q * abs(q) + M_UQ * u * q + M_UW * u * w - arm * -r2[0] - (i_p - i_r) * p * r
    o += N_RR * r * abs(r) + N_UR * u * r + N_UV * u * v - (i_q - i_p) * p * q
    cx, cy, cz = load.current
    return [
        r0[0] * u + r0[1] * v + r0[2] * w + cx,
        r1[0] * u + r1[1] * v + r1[2] * w + cy,
        r2[0] * u + r2[1] * v + r2[2] * w + cz,
        -0.5 * (a * p + b * q + c * r),
        0.5 * (n * p + b * r - c * q),
        0.5 * (n * q + c * p - a * r),
        0.5 * (n * r + a * q - b * p),
        fx / m_u,
        fy / m_v,
        fz / m_w,
        k / i_p,
        m / i_q,
        o / i_r,
    ]


def move(pose: Pose, load: Load, dt: float) -> Pose:
    """The state dt seconds later: Runge-Kutta of fourth order, quaternion brought back to length 1."""
    s = pose.vector()
    k1 = _rates(s, load)
    k2 = _rates([x + dt / 2 * d for x, d in zip(s, k1, strict=True)], load)
    k3 = _rates([x + dt / 2 * d for x, d in zip(s, k2, strict=True)], load)
    k4 = _rates([x + dt * d for x, d in zip(s, k3, strict=True)], load)
    s = [
        x + dt / 6 * (a + 2 * b + 2 * c + d)
        for x, a, b, c, d in zip(s, k1, k2, k3, k4, strict=True)
    ]
    norm = math.sqrt(sum(x * x for x in s[3:7]))
    n, a, b, c = (x / norm for x in s[3:7])
    return Pose(s[0], s[1], s[2], (n, a, b, c), (s[7], s[8], s[9]), (s[10], s[11], s[12]))
