"""The watchdog in simulated time: what it holds against a gateway, when, and how it lets go; and what the ECU makes of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.can.codec import FOLLOWING, TIMED_OUT
from vehicle_gateway.can.ecu_codec import Command, Motion
from vehicle_gateway.can.watch_codec import SHIPPED, Fault, StopState, decode_stop
from vehicle_gateway.simulation.ecu_core import EcuInputs, EcuSettings, EcuState, ecu_step
from vehicle_gateway.watchdog import DRIVEN, Heard, Watch, WatchLimits, watch_step
from wire.messages.base import Gear
from wire.messages.vehicle import Mode

LIMITS = WatchLimits()
MS = 1_000_000
M = Mode


class Bus:
    """A gateway that sends every 10 ms and a watchdog that looks every 20; each attribute is something that can fail."""

    def __init__(self, mode=M.REMOTE, speed=5.0, acceleration=0.5):
        self.now = 10**12
        self.watch, self.heard = Watch(), Heard()
        self.mode, self.speed, self.acceleration = mode, speed, acceleration
        self.sends, self.takes, self.moves_told = True, True, True
        self.sources = 1

    def run(self, ms):
        for _ in range(round(ms / 10)):
            self.now += 10 * MS
            self.sources += self.takes
            if self.sends:
                self.heard = replace(
                    self.heard,
                    command_ns=self.now,
                    mode=self.mode,
                    acceleration_m_s2=self.acceleration,
                    sources=self.sources % 65535,
                )
            if self.moves_told:
                self.heard = replace(self.heard, motion_ns=self.now, speed_m_s=self.speed)
            if self.now // MS % 20 == 0:
                self.watch = watch_step(self.watch, self.heard, self.now, LIMITS)
        return self

    @property
    def fault(self):
        return self.watch.fault


@pytest.mark.parametrize("mode", list(Mode))
def test_a_gateway_that_does_its_work_is_left_alone_in_every_mode(mode):
    driven = mode in DRIVEN
    assert Bus(mode, 3.0, 0.5 if driven else -1.0).run(5000).fault is Fault.NONE


def test_before_a_gateway_was_heard_nothing_is_asked_of_the_ecu():
    bus = Bus()
    bus.sends = False
    assert bus.run(5000).fault is Fault.NONE


def test_200_ms_without_a_valid_frame_is_silence_and_no_less():
    bus = Bus().run(1000)
    bus.sends = False
    assert bus.run(200).fault is Fault.NONE
    assert bus.run(20).fault is Fault.SILENT


def test_fresh_frames_with_nothing_new_behind_them_starve_after_700_ms():
    """A sender of its own repeats the last cycle with fresh counters; the cycle hangs, or its sources are silent."""
    for mode in DRIVEN:
        bus = Bus(mode).run(1000)
        bus.takes = False
        assert bus.run(700).fault is Fault.NONE
        assert bus.run(20).fault is Fault.STARVED


def test_a_mode_that_was_just_entered_has_its_own_700_ms_and_one_that_nobody_drives_never_starves():
    bus = Bus(M.STANDBY, 0.0, -2.0)
    bus.takes = False
    assert bus.run(5000).fault is Fault.NONE
    bus.mode, bus.acceleration = M.REMOTE, 0.5
    assert bus.run(700).fault is Fault.NONE
    assert bus.run(40).fault is Fault.STARVED


def test_a_car_without_the_source_frame_is_watched_for_the_rest():
    heard = Heard(command_ns=10**12, mode=M.REMOTE, motion_ns=10**12, speed_m_s=5.0)
    watch = watch_step(Watch(), heard, 10**12, LIMITS)
    later = replace(heard, command_ns=10**12 + 5000 * MS, motion_ns=10**12 + 5000 * MS)
    assert watch_step(watch, later, 10**12 + 5000 * MS, LIMITS).fault is Fault.NONE


@pytest.mark.parametrize("mode", [M.STANDBY, M.SAFE_STOP, M.STOPPED, M.EMERGENCY_STOP, M.LOCAL_DRIVER])
def test_traction_where_nobody_drives_is_stopped_after_200_ms_and_braking_never(mode):
    bus = Bus(mode, 1.0, 0.1)
    assert bus.run(200).fault is Fault.NONE
    assert bus.run(40).fault is Fault.UNDRIVEN
    assert Bus(mode, 1.0, -0.1).run(5000).fault is Fault.NONE
    assert Bus(mode, 1.0, 0.0).run(5000).fault is Fault.NONE


@pytest.mark.parametrize("mode", [M.AUTONOMOUS, M.REMOTE, M.HANDING_OVER, M.STANDBY, M.HANDING_BACK, M.TAKEOVER_REQUESTED])
def test_a_safe_stop_that_is_left_while_the_car_moves_is_stopped_at_once(mode):
    bus = Bus(M.SAFE_STOP, 3.0, -2.0).run(500)
    bus.mode = mode
    assert bus.run(20).fault is Fault.LEFT_STOP


@pytest.mark.parametrize("mode", [M.STOPPED, M.EMERGENCY_STOP, M.LOCAL_DRIVER])
def test_a_safe_stop_that_goes_on_as_the_table_has_it_is_left_alone(mode):
    bus = Bus(M.SAFE_STOP, 3.0, -2.0).run(500)
    bus.mode = mode
    assert bus.run(3000).fault is Fault.NONE


def test_it_lets_go_only_after_a_second_of_sanity_and_of_a_car_that_is_known_to_stand():
    bus = Bus().run(1000)
    bus.sends = False
    bus.run(500)
    bus.sends, bus.mode, bus.acceleration = True, M.SAFE_STOP, -2.0
    assert bus.run(3000).fault is Fault.SILENT  # sane, but it still rolls
    bus.speed, bus.moves_told = 0.0, False
    assert bus.run(3000).fault is Fault.SILENT  # nobody says that it stands
    bus.moves_told = True
    assert bus.run(40).fault is Fault.NONE


def test_a_gateway_that_flaps_is_never_let_go():
    bus = Bus(speed=0.0).run(1000)
    for _ in range(10):
        bus.sends = False
        bus.run(300)
        bus.sends = True
        assert bus.run(900).fault is Fault.SILENT


@given(
    st.lists(
        st.tuples(st.sampled_from(Mode), st.floats(-8.0, 2.0), st.floats(-2.0, 9.0), st.booleans(), st.booleans()), max_size=40
    )
)
def test_whatever_happens_a_moving_car_is_not_let_go(steps):
    bus = Bus()
    for mode, acceleration, speed, sends, takes in steps:
        bus.mode, bus.acceleration, bus.speed, bus.sends, bus.takes = mode, acceleration, speed, sends, takes
        before = bus.fault
        bus.run(20)
        if before and abs(speed) >= 0.05:
            assert bus.fault


@pytest.mark.parametrize(("slept_ms", "expected"), [(60, Fault.SILENT), (80, Fault.NONE), (3000, Fault.NONE)])
def test_a_watchdog_that_was_away_itself_accuses_nobody_of_that_time(slept_ms, expected):
    """It wakes before its reader has caught up with what lies on the bus."""
    bus = Bus().run(1000)
    bus.sends = False
    bus.run(160)
    bus.now += slept_ms * MS
    bus.watch = watch_step(bus.watch, bus.heard, bus.now, LIMITS)
    assert bus.fault is expected
    bus.sends = True
    assert bus.run(100).fault is expected


def test_a_gateway_that_is_silent_after_the_watchdog_woke_is_noticed_200_ms_later():
    bus = Bus().run(1000)
    bus.sends = False
    bus.now += 3000 * MS
    assert bus.run(200).fault is Fault.NONE
    assert bus.run(40).fault is Fault.SILENT


# -- on the far side ------------------------------------------------------------------------------------------------------


def test_the_frame_carries_each_fault_and_a_wrong_or_repeated_one_is_dropped():
    state = StopState()
    for counter, fault in enumerate(Fault):
        state, reason = decode_stop(state, SHIPPED.encode_stop(fault, counter))
        assert (state.fault, reason) == (fault, "")
    again, reason = decode_stop(state, SHIPPED.encode_stop(Fault.NONE, len(Fault) - 1))
    assert (again.fault, reason) == (Fault.STARVED, "can counter")
    broken = SHIPPED.encode_stop(Fault.NONE, 5)
    broken = broken._replace(data=bytes([broken.data[0] ^ 1]) + broken.data[1:])
    assert decode_stop(state, broken)[1] == "can crc"


def obeyed(stop_age_ms, speed, condition=FOLLOWING):
    now = 10**12
    inputs = EcuInputs(
        command=Command(M.REMOTE, 0.0, 1.0, Gear.DRIVE, False),
        command_ns=now,
        motion=Motion(speed, 0.0, 0.0, 0.0),
        motion_ns=now,
        stop_ns=None if stop_age_ms is None else now - round(stop_age_ms * MS),
    )
    return ecu_step(EcuState(condition=condition, acceleration_m_s2=0.0, stepped_ns=now - 10 * MS), inputs, now, EcuSettings())


def test_the_ecu_brakes_on_the_watchdogs_word_though_fresh_commands_drive():
    state, demand = obeyed(0.0, 5.0)
    assert state.condition == TIMED_OUT
    assert (demand.drive_m_s2, demand.hazard) == (0.0, True)
    assert state.acceleration_m_s2 == pytest.approx(-0.1)  # 10 ms of 10 m/s3


@pytest.mark.parametrize(("age_ms", "speed", "follows"), [(100.0, 0.0, False), (100.1, 0.0, True), (100.1, 0.1, False)])
def test_the_ecu_follows_again_when_the_watchdog_is_content_and_the_car_stands(age_ms, speed, follows):
    assert (obeyed(age_ms, speed, TIMED_OUT)[0].condition == FOLLOWING) == follows


def test_a_watchdog_that_is_silent_stops_nothing():
    assert obeyed(None, 5.0)[0].condition == FOLLOWING
    assert obeyed(150.0, 5.0)[0].condition == FOLLOWING
