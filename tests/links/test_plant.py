"""The body in the water reaches the planning figures, and does not make energy."""

from __future__ import annotations

import random
from math import cos, degrees, hypot, sin

import pytest

from links.simulated.plant import (
    DEAD_BAND_PWM,
    GEAR_PWM,
    NEUTRAL,
    NEUTRAL_PWM,
    TICK,
    TICK_STEPS,
    Body,
    Plant,
)


def pwm(left: float, right: float, vertical: float, servo_deg: float = 0.0) -> tuple[int, ...]:
    gears = (left, right, vertical, vertical, vertical)
    servo = round(NEUTRAL_PWM + 10 * servo_deg)
    return (*(round(NEUTRAL_PWM + gear * GEAR_PWM) for gear in gears), servo, servo)


def fly(actuators: tuple[int, ...], seconds: float, plant: Plant | None = None) -> Plant:
    plant = plant or Plant(floor=500.0)
    for _ in range(round(seconds / TICK)):
        plant.drive(actuators)
        plant.run(TICK_STEPS)
    return plant


def deep(depth: float = 100.0, body: Body | None = None) -> Plant:
    plant = Plant(body, floor=500.0)
    plant.depth = depth
    return plant


@pytest.mark.parametrize(
    ("gear", "speed"), [(0, 0.0), (2, 0.2), (4, 0.45), (6, 0.75), (8, 1.0), (10, 1.25), (12, 1.25)]
)
def test_terminal_speed_is_the_planning_figure(gear: int, speed: float) -> None:
    assert fly(pwm(gear, gear, 0), 60).u == pytest.approx(speed, rel=0.06, abs=1e-6)


def test_gear_ten_is_full_speed() -> None:
    assert fly(pwm(10, 10, 0), 60).u == fly(pwm(12, 12, 0), 60).u


@pytest.mark.parametrize(
    ("gear", "rate"), [(-10, 0.35), (0, -0.25), (12, -0.5)], ids=["dive", "buoyancy", "thrust up"]
)
def test_vertical_rates_are_the_planning_figures(gear: int, rate: float) -> None:
    assert fly(pwm(0, 0, gear), 60, deep()).depth_rate == pytest.approx(rate, rel=0.05)


@pytest.mark.parametrize("gear", [-1, -2, -3, -4])
def test_below_gear_five_the_verticals_do_not_overcome_the_buoyancy(gear: int) -> None:
    assert fly(pwm(0, 0, gear), 60, deep()).depth_rate < -0.05


def test_from_gear_five_the_verticals_do_overcome_the_buoyancy() -> None:
    assert fly(pwm(0, 0, -5), 60, deep()).depth_rate > 0.02


@pytest.mark.parametrize("sign", [-1, 1])
def test_inside_the_dead_band_a_thruster_does_not_turn(sign: int) -> None:
    inside = NEUTRAL_PWM + sign * int(DEAD_BAND_PWM)
    plant = fly((inside,) * 5 + NEUTRAL[5:], 5)
    assert plant.thrust == (0.0,) * 5
    outside = inside + sign
    assert all(sign * thrust > 0 for thrust in fly((outside,) * 5 + NEUTRAL[5:], 5).thrust)


def test_a_turn_runs_at_about_twelve_degrees_a_second_and_within_a_few_metres() -> None:
    plant = fly(pwm(8, 1, 0), 60)
    radius = hypot(plant.u, plant.v) / plant.r
    assert degrees(plant.r) == pytest.approx(12.0, abs=2.0)
    assert 1.5 < radius < 3.5


def test_left_thruster_ahead_turns_to_starboard() -> None:
    assert fly(pwm(5, -5, 0), 3).r > 0.05
    assert fly(pwm(-5, 5, 0), 3).r < -0.05


def test_equal_verticals_do_not_pitch_or_roll() -> None:
    plant = fly(pwm(0, 0, -10), 20, deep())
    assert abs(plant.pitch) < 1e-6
    assert abs(plant.roll) < 1e-6


def test_rudders_up_raise_the_nose() -> None:
    assert fly(pwm(10, 10, 0, servo_deg=15), 20, deep()).pitch > 0.05
    assert fly(pwm(10, 10, 0, servo_deg=-15), 20, deep()).pitch < -0.05


def test_roll_and_pitch_right_themselves() -> None:
    plant = deep()
    plant.roll, plant.pitch = 1.0, 0.6
    plant = fly(NEUTRAL, 60, plant)
    assert abs(plant.roll) < 0.01
    assert abs(plant.pitch) < 0.01


def test_floats_at_the_surface_with_the_antenna_out_of_the_water() -> None:
    plant = fly(NEUTRAL, 120, deep(5.0))
    assert 0.1 < plant.depth < 0.3
    assert abs(plant.depth_rate) < 0.005


def test_does_not_fly_out_of_the_water() -> None:
    plant, highest = deep(3.0), 1.0
    for _ in range(300):
        plant = fly(pwm(0, 0, 12), TICK, plant)
        highest = min(highest, plant.depth)
    assert highest > -0.3


def test_the_floor_stops_the_descent_and_holds_against_the_current() -> None:
    plant = Plant(floor=10.0)
    plant.current_north = 0.3
    plant.depth = 9.0
    plant = fly(pwm(0, 0, -10), 30, plant)
    assert plant.depth == pytest.approx(10.0 - plant.body.floor_clearance)
    assert plant.aground
    north = plant.north
    assert fly(pwm(0, 0, -10), 10, plant).north == pytest.approx(north)
    assert fly(NEUTRAL, 20, plant).depth < 9.0


def test_drifts_with_the_current_and_no_faster() -> None:
    plant = Plant()
    plant.current_north, plant.current_east = 0.3, -0.1
    plant = fly(NEUTRAL, 100, plant)
    assert plant.north == pytest.approx(30.0, rel=1e-6)
    assert plant.east == pytest.approx(-10.0, rel=1e-6)
    assert plant.ground_velocity() == pytest.approx((0.3, -0.1))


def masses(plant: Plant) -> tuple[float, ...]:
    b = plant.body
    return (b.mass_u, b.mass_v, b.mass_w, b.inertia_p, b.inertia_q, b.inertia_r)


def velocities(plant: Plant) -> tuple[float, ...]:
    return (plant.u, plant.v, plant.w, plant.p, plant.q, plant.r)


def kinetic(plant: Plant, of: tuple[float, ...]) -> float:
    return sum(m * x * x / 2 for m, x in zip(masses(plant), of, strict=True))


def energy(plant: Plant) -> float:
    b = plant.body
    righting = b.righting * (1 - cos(plant.pitch) * cos(plant.roll))
    return kinetic(plant, velocities(plant)) + righting + b.buoyancy * plant.depth


def tumbling(body: Body) -> Plant:
    plant = deep(200.0, body)
    plant.u, plant.v, plant.w, plant.p, plant.q, plant.r = 0.8, -0.3, 0.2, 0.3, 0.05, 0.2
    return plant


def test_coriolis_forces_do_no_work() -> None:
    """One explicit step then gains the kinetic energy of the change, and not a bit more."""
    free = Body(
        linear=(0.0,) * 6, quadratic=(0.0,) * 6, fin_pitch=0.0, fin_yaw=0.0, fin_damping=0.0,
        buoyancy=0.0, righting=0.0, inertia_r=55.0,
    )  # fmt: skip
    plant = tumbling(free)
    before = velocities(plant)
    plant.run(1)
    after = velocities(plant)
    change = tuple(b - a for a, b in zip(before, after, strict=True))
    assert kinetic(plant, change) > 1e-3
    gained = kinetic(plant, after) - kinetic(plant, before)
    assert gained == pytest.approx(kinetic(plant, change), rel=1e-9)


def test_without_thrust_energy_only_falls() -> None:
    plant = tumbling(Body(fin_pitch=0.0, fin_yaw=0.0))
    last = energy(plant)
    for _ in range(200):
        plant.run(TICK_STEPS)
        assert energy(plant) < last + 1e-3
        last = energy(plant)


def test_any_actuators_keep_the_state_finite_and_upright() -> None:
    rng = random.Random(5)
    plant = deep(50.0)
    for _ in range(400):
        plant = fly((*(rng.randint(1000, 2000) for _ in range(5)), 1350, 1720), 0.5, plant)
        plant.depth = min(max(plant.depth, 20.0), 80.0)
        assert hypot(plant.u, plant.v, plant.w) < 3.0
        assert abs(sin(plant.pitch)) < 0.95
        assert abs(plant.roll) < 1.5


def test_a_weak_thruster_pulls_the_bow_round_and_can_recover() -> None:
    plant = Plant()
    plant.weaken(0, 0.4)
    plant = fly(pwm(8, 8, 0), 10, plant)
    assert plant.r < -0.05
    plant.weaken(0, 1.0)
    assert abs(fly(pwm(8, 8, 0), 60, plant).r) < 1e-3


def test_cutting_the_run_does_not_change_the_path() -> None:
    whole, cut = deep(), deep()
    for plant in (whole, cut):
        plant.drive(pwm(8, 3, -7))
    whole.run(100)
    for _ in range(100):
        cut.run(1)
    assert (whole.north, whole.yaw, whole.q) == (cut.north, cut.yaw, cut.q)
