"""The body in the water: 6-DOF dynamics in Fossen's form (eta, nu), in plain floats.

T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, Wiley 2011:
M nu' + C(nu) nu + D(nu) nu + g(eta) = tau (chapter 6), eta' = J(eta) nu + current (equation 8.x:
nu is the velocity through the water, the current is irrotational and changes slowly). M is
diagonal with the added mass in it, C is Kirchhoff's for that M, D is linear plus quadratic, g is
a net buoyancy and a righting moment. eta = north, east, down of the pressure sensor, roll, pitch,
yaw; nu = u forward, v starboard, w down, p, q, r. Semi-implicit Euler, fixed step of 0.05 s.

Every figure of ``Body`` is tuned to the planning figures of the vehicle file (speed by gear, dive
and ascent rates, turn rate, turning radius); masses and areas are those of a 2 m, 75 kg hull.

What does not live here: sensors, firmware, positions on the globe (geodesy.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, exp, radians, sin

STEP = 0.05  # s
TICK_STEPS = 4  # plant steps of one control tick
TICK = STEP * TICK_STEPS  # s

NEUTRAL_PWM = 1500
GEAR_PWM = 500 / 12  # us of one gear: gear 12 is 2000 us
FULL_PWM = 10 * GEAR_PWM  # us off neutral where the thrusters saturate: gear 10 is full speed
DEAD_BAND_PWM = 20.0  # us off neutral below which a thruster does not turn
SERVO_PWM = 10.0  # us of one degree of rudder

# Order of the PWMs on the wire: left main, right main, rear, left, right vertical, two servos.
LEFT_MAIN, RIGHT_MAIN, REAR, LEFT, RIGHT, SERVO_LEFT, SERVO_RIGHT = range(7)
NEUTRAL = (NEUTRAL_PWM,) * 7

HEEL = radians(10.0)  # heel of the hull when its ballast moves
_NEAR = 1e-3  # N: a thruster this near to its target has reached it


@dataclass(frozen=True, slots=True)
class Body:
    """Parameters, SI units. Masses and inertias include the added ones."""

    mass_u: float = 90.0
    mass_v: float = 155.0
    mass_w: float = 185.0
    inertia_p: float = 5.0
    inertia_q: float = 40.0
    inertia_r: float = 40.0
    linear: tuple[float, ...] = (0.5, 10.0, 1.0, 6.0, 20.0, 5.0)  # N s/m, N m s
    quadratic: tuple[float, ...] = (51.2, 200.0, 240.0, 5.0, 60.0, 70.0)
    fin_pitch: float = 90.0  # N m per (m/s)^2 of u w: fins against Munk's moment
    fin_yaw: float = 75.0  # the same for u v
    fin_damping: float = 5.0  # N m per u r and u q
    buoyancy: float = 15.0  # N, net, upward
    righting: float = 30.0  # N m per sine of roll or pitch
    draft: float = 0.2  # m, depth of the sensor at which the hull begins to emerge
    waterplane: float = 1875.0  # N/m of emergence
    surface_damping: float = 300.0  # N s/m in heave while emerged: radiated waves
    main_thrust: float = 40.0  # N, one main thruster, saturated
    main_power: float = 2.0  # thrust ~ (PWM beyond the dead band) ** power
    vertical_thrust: float = 14.8  # N, one vertical thruster, saturated
    vertical_power: float = 1.4
    arm_main: float = 0.25  # m, each main thruster from the centre line
    arm_front: float = 0.4  # m, front verticals ahead of the centre
    arm_rear: float = 0.8  # m, rear vertical behind the centre: equal gears do not pitch
    arm_side: float = 0.2  # m, front verticals from the centre line
    thrust_lag: float = 0.2  # s
    rudder_pitch: float = 15.0  # N m per (m/s)^2 and rad, both rudders
    rudder_roll: float = 3.0  # N m per (m/s)^2 and rad of difference
    floor_clearance: float = 0.2  # m, sensor above the bottom when lying on it


def _thrust_table(full: float, power: float) -> tuple[float, ...]:
    """Thrust in N by PWM - 1000, positive above neutral; antisymmetric."""
    values = []
    for offset in range(-500, 501):
        beyond = max(0.0, min(abs(offset), FULL_PWM) - DEAD_BAND_PWM)
        thrust = full * (beyond / (FULL_PWM - DEAD_BAND_PWM)) ** power
        values.append(thrust if offset > 0 else -thrust)
    return tuple(values)


class Plant:
    """The state of the body; ``drive`` sets the actuators for a tick, ``run`` integrates."""

    # Too many attributes for a key-sharing dict: without slots each access is slower.
    # fmt: off
    __slots__ = (
        "_constants", "_forces", "_main", "_pwm", "_rudders", "_servos", "_settled", "_share",
        "_target", "_thrust", "_vertical", "aground", "body", "buoyancy", "current_east",
        "current_north", "depth", "depth_rate", "east", "floor", "heeling", "north", "p", "pitch",
        "q", "r", "righting", "roll", "strength", "u", "v", "w", "weak", "yaw",
    )
    # fmt: on

    def __init__(self, body: Body | None = None, *, floor: float = 30.0) -> None:
        self.body = body or Body()
        self.floor = floor
        self.north = self.east = 0.0
        self.depth = self.body.draft - self.body.buoyancy / self.body.waterplane
        self.roll = self.pitch = self.yaw = 0.0
        self.u = self.v = self.w = self.p = self.q = self.r = 0.0
        self.depth_rate = 0.0
        self.current_north = self.current_east = 0.0
        self.buoyancy = self.body.buoyancy
        self.righting = self.body.righting  # N m; below 0 it lies upside down
        self.heeling = 0.0  # N m to starboard, from weight off the keel line
        self.strength = [1.0] * 5  # share of its thrust that each thruster still has
        self.weak: list[list[float]] = [[] for _ in range(5)]  # shares that faults leave
        self.aground = False
        self._main = _thrust_table(self.body.main_thrust, self.body.main_power)
        self._vertical = _thrust_table(self.body.vertical_thrust, self.body.vertical_power)
        self._share = 1.0 - exp(-TICK / self.body.thrust_lag)
        self._thrust = self._target = (0.0,) * 5
        self._pwm: tuple[int, ...] = NEUTRAL
        self._settled = True
        # X, Z, K, M, N of the thrusters; pitch and roll moment of the rudders per u |u|
        self._forces = (0.0,) * 5
        self._rudders = (0.0, 0.0)
        self._servos = (NEUTRAL_PWM, NEUTRAL_PWM)
        self._constants = self._per_step()

    def _per_step(self) -> tuple[float, ...]:
        """Constants of the body for ``run``, in the order in which it unpacks them."""
        b, dt = self.body, STEP
        return (
            *(b.mass_u, b.mass_v, b.mass_w),
            *(dt / b.mass_u, dt / b.mass_v, dt / b.mass_w),
            *(dt / b.inertia_p, dt / b.inertia_q, dt / b.inertia_r),
            b.mass_v - b.mass_w,
            b.mass_w - b.mass_u - b.fin_pitch,
            b.mass_u - b.mass_v + b.fin_yaw,
            *(b.inertia_q - b.inertia_r, b.inertia_r - b.inertia_p, b.inertia_p - b.inertia_q),
            *(b.fin_damping, self.righting, self.heeling, b.draft, b.waterplane, b.surface_damping),
            *b.linear,
            *b.quadratic,
        )

    @property
    def thrust(self) -> tuple[float, ...]:
        """N of each thruster in the order of the PWMs."""
        return self._thrust

    def ground_velocity(self) -> tuple[float, float]:
        """North and east over ground, m/s."""
        if self.aground:
            return 0.0, 0.0
        v, w, sr, cr = self.v, self.w, sin(self.roll), cos(self.roll)
        below, across = v * sr + w * cr, v * cr - w * sr
        ahead = self.u * cos(self.pitch) + below * sin(self.pitch)
        sy, cy = sin(self.yaw), cos(self.yaw)
        return (
            ahead * cy - across * sy + self.current_north,
            ahead * sy + across * cy + self.current_east,
        )

    def weaken(self, thruster: int, share: float) -> None:
        self.strength[thruster] = share
        self._pwm = ()  # so that the next ``drive`` computes its targets again

    def load(self, righting: float, heeling: float = 0.0) -> None:
        """Set new moments, as after ballast has moved. The hull is heeled by ``HEEL``, because none
        is ever exactly level."""
        self.righting, self.heeling = righting, heeling
        self.roll += HEEL
        self._constants = self._per_step()

    def drive(self, pwm: tuple[int, ...]) -> None:
        """Let the thrusters follow seven PWMs (1000..2000) for one tick, with first order lag."""
        aimed = pwm != self._pwm
        if aimed:
            self._aim(pwm)
        elif self._settled:
            return
        share = self._share
        a, b, c, d, e = self._target
        left_main, right_main, rear, left, right = self._thrust
        a -= left_main
        b -= right_main
        c -= rear
        d -= left
        e -= right
        if not aimed:
            near = _NEAR
            mains = -near < a < near and -near < b < near
            if mains and -near < c < near and -near < d < near and -near < e < near:
                self._settled, share = True, 1.0
        left_main += share * a
        right_main += share * b
        rear += share * c
        left += share * d
        right += share * e
        self._thrust = (left_main, right_main, rear, left, right)
        body = self.body
        self._forces = (
            left_main + right_main,
            -(rear + left + right),
            body.arm_side * (left - right),
            body.arm_front * (left + right) - body.arm_rear * rear,
            body.arm_main * (left_main - right_main),
        )

    def _aim(self, pwm: tuple[int, ...]) -> None:
        self._pwm = pwm
        self._settled = False
        left_main, right_main, rear, left, right, servo_left, servo_right = pwm
        main, vertical = self._main, self._vertical
        strong_a, strong_b, strong_c, strong_d, strong_e = self.strength
        self._target = (
            main[left_main - 1000] * strong_a,
            main[right_main - 1000] * strong_b,
            vertical[rear - 1000] * strong_c,
            vertical[left - 1000] * strong_d,
            vertical[right - 1000] * strong_e,
        )
        known_left, known_right = self._servos
        if servo_left != known_left or servo_right != known_right:
            self._turn_rudders(servo_left, servo_right)

    def _turn_rudders(self, left: int, right: int) -> None:
        self._servos = left, right
        port = radians((left - NEUTRAL_PWM) / SERVO_PWM)
        starboard = radians((right - NEUTRAL_PWM) / SERVO_PWM)
        body = self.body
        self._rudders = (
            body.rudder_pitch * (port + starboard) / 2,
            body.rudder_roll * (starboard - port),
        )

    def run(self, steps: int) -> None:
        """Integrate with constant forces. The hot loop: one function with local names."""
        dt = STEP
        (
            mu, mv, mw, du, dv, dw, dp, dq, dr, cp, cq, cr, gp, gq, gr, fin, righting, heeling,
            draft, waterplane, radiation, xu, yv, zw, kp, mq, nr, xuu, yvv, zww, kpp, mqq, nrr,
        ) = self._constants  # fmt: skip
        surge, heave, roll_moment, pitch_moment, yaw_moment = self._forces
        rudder_pitch, rudder_roll = self._rudders
        current_north, current_east = self.current_north, self.current_east
        net = self.buoyancy
        north, east, depth = before = self.north, self.east, self.depth
        roll, pitch, yaw = self.roll, self.pitch, self.yaw
        u, v, w, p, q, r = self.u, self.v, self.w, self.p, self.q, self.r
        down = self.depth_rate
        for _ in range(steps):
            sr, cr_ = sin(roll), cos(roll)
            sp, cp_ = sin(pitch), cos(pitch)
            if depth >= draft:
                lift = net
                z = heave
            else:
                lift = net - waterplane * (draft - depth)
                z = heave - radiation * w
            level = lift * cp_
            muu, mvv, mww = mu * u, mv * v, mw * w
            munk_p, munk_q, munk_r = cp * v * w, cq * u * w, cr * u * v
            gyro_q, gyro_r = gq * p * r, gr * p * q
            au = u if u > 0.0 else -u
            uu, fin_au = u * au, fin * au
            u += du * (surge + mvv * r - mww * q - u * xu - uu * xuu + lift * sp)
            v += dv * (
                mww * p - muu * r
                - v * (yv + yvv * (v if v > 0.0 else -v)) - level * sr
            )  # fmt: skip
            w += dw * (
                z + muu * q - mvv * p
                - w * (zw + zww * (w if w > 0.0 else -w)) - level * cr_
            )  # fmt: skip
            p += dp * (
                roll_moment + munk_p + gp * q * r + rudder_roll * uu
                - p * (kp + kpp * (p if p > 0.0 else -p)) - righting * cp_ * sr
                + heeling * cp_ * cr_
            )  # fmt: skip
            q += dq * (
                pitch_moment + munk_q + gyro_q + rudder_pitch * uu
                - q * (mq + fin_au + mqq * (q if q > 0.0 else -q)) - righting * sp
            )  # fmt: skip
            r += dr * (
                yaw_moment + munk_r + gyro_r
                - r * (nr + fin_au + nrr * (r if r > 0.0 else -r)) + heeling * sp
            )  # fmt: skip
            across = v * cr_ - w * sr
            below = v * sr + w * cr_
            ahead = u * cp_ + below * sp
            turning = (q * sr + r * cr_) / cp_
            down = below * cp_ - u * sp
            sy, cy = sin(yaw), cos(yaw)
            north += dt * (ahead * cy - across * sy + current_north)
            east += dt * (ahead * sy + across * cy + current_east)
            depth += dt * down
            roll += dt * (p + turning * sp)
            pitch += dt * (q * cr_ - r * sr)
            yaw += dt * turning
        self.north, self.east, self.depth = north, east, depth
        self.roll, self.pitch, self.yaw = roll, pitch, yaw
        self.u, self.v, self.w, self.p, self.q, self.r = u, v, w, p, q, r
        self.depth_rate = down
        self.aground = depth > self.floor - self.body.floor_clearance
        if self.aground:
            self._lie(before)

    def _lie(self, before: tuple[float, float, float]) -> None:
        """Lie on the ground: no deeper, and no motion over it. Checked once per ``run``."""
        self.north, self.east, _ = before
        self.depth = self.floor - self.body.floor_clearance
        self.u = self.v = self.w = self.depth_rate = 0.0
