from dataclasses import replace
from math import inf, nan

from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from haptics.virtual_wheel import VirtualWheel
from tests.messages import vehicle_description
from tower.cockpit.command import Stamps, Wanted, built, is_urgent, moved, trusted, wanted
from tower.cockpit.devices import Controls, Presses, newly_pressed
from tower.cockpit.pedals import Arming, PedalSettings, acceleration_m_s2, arm, pedals_for
from wire.messages.base import decoder, encode
from wire.messages.operating import DriveCommand
from wire.signature import is_genuine, sign

CAR = vehicle_description()
PEDALS = PedalSettings()
NOW_NS = 10**12
HELD = Controls(
    wheel=VirtualWheel(0.5), throttle=0.5, throttle_reported=True, brake_reported=True, dead_man=True, horn=True, sample_ns=NOW_NS
)
STAMPS = Stamps(sent_ns=NOW_NS, event_ns=NOW_NS, echoed_vehicle_ns=5, echoed_boot_id="b", displayed_capture_ns={"front": 4})
ANY = st.floats(allow_nan=True, allow_infinity=True)
PEDAL = st.floats(0, 1)


@given(
    angle=ANY, rate=ANY, throttle=ANY, brake=ANY, age_ns=st.integers(-(10**9), 10**10), dead_man=st.booleans(), armed=st.booleans()
)
def test_whatever_a_device_says_the_car_can_decode_the_command_and_an_old_or_broken_sample_has_no_dead_man(
    angle: float, rate: float, throttle: float, brake: float, age_ns: int, dead_man: bool, armed: bool
) -> None:
    raw = replace(
        HELD, wheel=VirtualWheel(angle, rate), throttle=throttle, brake=brake, dead_man=dead_man, sample_ns=NOW_NS - age_ns
    )
    controls = trusted(raw, HELD, NOW_NS)
    want = wanted(controls, controls.wheel.angle_rad, armed, CAR, PEDALS)
    command = decoder(DriveCommand).decode(encode(built(want, 3, 7, STAMPS)))  # refuses NaN and every range
    assert abs(command.road_wheel_angle_rad) <= 0.6
    broken = any(number - number != 0 for number in (angle, rate, throttle, brake))
    if age_ns > 100_000_000 or broken or not dead_man:
        assert not command.dead_man
    if not command.dead_man or not armed:
        assert command.acceleration_m_s2 <= -0.5 + 1e-9


def test_a_sample_101_ms_old_counts_as_released_and_one_of_99_ms_does_not() -> None:
    old, young = (trusted(replace(HELD, sample_ns=NOW_NS - age * 10**6), HELD, NOW_NS) for age in (101, 99))
    assert (old.dead_man, old.throttle, old.horn, old.throttle_reported) == (False, 0.0, False, False)
    assert young.dead_man and young.throttle == 0.5


def test_a_wheel_that_is_not_a_number_stays_where_it_was() -> None:
    for broken in (nan, inf, -inf):
        assert trusted(replace(HELD, wheel=VirtualWheel(broken)), HELD, NOW_NS).wheel.angle_rad == 0.5


def test_a_command_is_signed_over_all_it_says() -> None:
    command = sign(built(Wanted(dead_man=True), 3, 7, STAMPS), b"k" * 32)
    assert is_genuine(command, b"k" * 32)
    assert (command.lease_epoch, command.sequence, command.echoed_vehicle_ns) == (3, 7, 5)
    assert command.displayed_capture_ns == {"front": 4}


@given(throttle=PEDAL, brake=PEDAL)
def test_acceleration_lies_between_full_brake_and_full_throttle_and_the_brake_wins(throttle: float, brake: float) -> None:
    acceleration = acceleration_m_s2(throttle, brake, 2.0, PEDALS)
    assert -6.0 <= acceleration <= 2.0
    if brake > PEDALS.dead_zone:
        assert acceleration == acceleration_m_s2(0.0, brake, 2.0, PEDALS) <= -0.5


@given(a=PEDAL, b=PEDAL)
def test_more_pedal_is_never_less(a: float, b: float) -> None:
    low, high = sorted((a, b))
    assert acceleration_m_s2(low, 0.0, 2.0, PEDALS) <= acceleration_m_s2(high, 0.0, 2.0, PEDALS)
    assert acceleration_m_s2(0.0, low, 2.0, PEDALS) >= acceleration_m_s2(0.0, high, 2.0, PEDALS)


def test_the_ends_of_the_pedals_are_the_limits_and_a_released_one_brakes_gently() -> None:
    assert acceleration_m_s2(1.0, 0.0, 2.0, PEDALS) == 2.0
    assert acceleration_m_s2(0.0, 1.0, 2.0, PEDALS) == -6.0
    assert acceleration_m_s2(0.04, 0.04, 2.0, PEDALS) == -0.5


@given(acceleration=st.floats(-6, 2))
def test_a_practised_foot_finds_every_acceleration(acceleration: float) -> None:
    assert abs(acceleration_m_s2(*pedals_for(acceleration, 2.0, PEDALS), 2.0, PEDALS) - acceleration) < 1e-6


def test_pedals_arm_only_after_each_has_reported_and_was_seen_released() -> None:
    silent = Controls(wheel=VirtualWheel())
    pressed = replace(silent, throttle=1.0, throttle_reported=True, brake_reported=True)
    released = replace(pressed, throttle=0.0)
    assert not arm(Arming(), silent, False, PEDALS).armed
    half = arm(Arming(), pressed, False, PEDALS)
    assert not half.armed and half.brake_seen_released
    whole = arm(half, released, False, PEDALS)
    assert whole.armed and arm(whole, pressed, False, PEDALS).armed


def test_a_stop_disarms_pedals_that_are_still_pressed() -> None:
    pressed = replace(HELD, throttle=1.0)
    assert not arm(Arming(True, True), pressed, True, PEDALS).armed


def test_buttons_are_counters_so_a_lost_sample_loses_no_press_and_a_restarted_window_presses_nothing() -> None:
    assert newly_pressed(None, Presses(stop=3)) == frozenset()
    assert newly_pressed(Presses(stop=3), Presses(stop=5, accept=1)) == {"stop", "accept"}
    assert newly_pressed(Presses(stop=5), Presses()) == frozenset()


def test_a_switch_and_the_beginning_of_a_movement_are_urgent_and_going_on_is_not() -> None:
    sent = Wanted(road_wheel_angle_rad=0.1, dead_man=True)
    further = structs.replace(sent, road_wheel_angle_rad=0.1001)
    assert is_urgent(sent, None, False, 14.0) and not is_urgent(sent, sent, False, 14.0)
    for was_moving in (False, True):
        assert is_urgent(structs.replace(sent, dead_man=False), sent, was_moving, 14.0)
        assert is_urgent(further, sent, was_moving, 14.0) is not was_moving
        assert is_urgent(structs.replace(sent, acceleration_m_s2=-0.1), sent, was_moving, 14.0) is not was_moving
    assert moved(further, sent, 14.0)
    assert not moved(structs.replace(sent, road_wheel_angle_rad=0.10001), sent, 14.0)
