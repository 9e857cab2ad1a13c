"""What may be sent: the list is the DBC's, everything else is refused, and the rate is what a plain count says it is."""

import queue
from dataclasses import replace

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.codec import FeedbackState, codec_of
from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.ecu_codec import Controls, encode_controls
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import LEAST_PERIOD_MS, layouts
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.transmit import Sending, admit
from vehicle_gateway.can.vehicles import CarBus, car_bus_of
from vehicle_gateway.gateway import SHORTEST_NS, open_car
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import Actuation, Mode, VehicleDescription

MS = 1_000_000
CODEC = codec_of(layouts())
PERMITS = CODEC.permits
COMMAND = layouts()["ACTUATION_COMMAND"]
PERIOD_NS = COMMAND.least_period_ms * MS
BRAKING = Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=-1.0)


def command(counter: int = 0) -> Frame:
    return CODEC.encode_command(BRAKING, Mode.REMOTE, False, counter)[0]


def admitted(times_ns, frame=None):
    state, taken = Sending(), []
    for at_ns in times_ns:
        state, refusal = admit(state, frame or command(), at_ns, PERMITS)
        assert refusal in ("", "too soon")
        if not refusal:
            taken.append(at_ns)
    return taken


def test_the_list_is_what_the_dbc_says_the_gateway_transmits_and_nothing_else():
    database = cantools.database.load_file(shipped("drive_by_wire.dbc"))
    ours = {message.frame_id: (message.name, message.length) for message in database.messages if message.senders == ["GATEWAY"]}
    vehicle = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
    permits = car_bus_of(CanSettings(), vehicle).permits
    assert {identifier: (permit.name, permit.size) for identifier, permit in permits.items()} == ours
    assert {permit.protection for permit in permits.values()} == {"E2E Profile 1"}


def test_another_car_s_list_has_its_own_identifier_length_and_period():
    theirs = dict(layouts())
    theirs["ACTUATION_COMMAND"] = replace(COMMAND, arbitration_id=0x12C, size=8, least_period_ms=20)
    permits = codec_of(theirs).permits
    assert set(permits) == {0x12C, layouts()["BODY_COMMAND"].arbitration_id}
    assert (permits[0x12C].size, permits[0x12C].least_period_ns) == (8, 20 * MS)


def test_the_period_of_the_shipped_dbc_is_the_shortest_cycle_of_the_gateway_and_so_is_that_of_one_that_says_none():
    assert {permit.least_period_ns for permit in PERMITS.values()} == {SHORTEST_NS}
    assert LEAST_PERIOD_MS * MS == SHORTEST_NS
    assert layouts()["MOTION_FEEDBACK"].least_period_ms == LEAST_PERIOD_MS


@pytest.mark.parametrize(
    ("frame", "refusal"),
    [
        (command(), ""),
        (Frame(0x7FF, bytes(8)), "not on the list"),
        (encode_controls(Controls(), 0), "not on the list"),  # the car's own frame: nobody may speak for it
        (command()._replace(data=command().data + b"\0"), "wrong length"),
        (command()._replace(data=b""), "wrong length"),
        (command()._replace(data=command().data[:-1] + b"\xff"), "wrong protection"),
        (Frame(COMMAND.arbitration_id, layouts()["ECU_LOAD"].pack((0.0, 0.0, 0.0), 0).data), "wrong protection"),  # another data id
    ],
)
def test_only_a_listed_frame_of_its_length_and_protection_passes(frame, refusal):
    assert admit(Sending(), frame, 0, PERMITS)[1] == refusal


@settings(deadline=None)  # a busy machine is no error
@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_whatever_is_not_ours_is_refused_and_takes_no_slot(identifier, data):
    state = Sending()
    after, refusal = admit(state, Frame(identifier, data), 0, PERMITS)
    genuine = (
        identifier in PERMITS and len(data) == PERMITS[identifier].size and PERMITS[identifier].is_intact(Frame(identifier, data))
    )
    assert (refusal == "", after != state) == (genuine, genuine)


@settings(deadline=None)  # a busy machine is no error
@given(st.lists(st.tuples(st.integers(SHORTEST_NS, 10 * MS), st.floats(0.0, 1.0)), min_size=2, max_size=60))
def test_the_gateway_is_never_refused_however_late_its_cycles_send(cycles):
    """Cycles at least 4 ms apart; each sends anywhere between its own reading of the clock and the next one's."""
    starts = [sum(step for step, _ in cycles[:number]) for number in range(len(cycles))]
    sent = [start + round((after - start) * late) for start, after, (_, late) in zip(starts, starts[1:], cycles, strict=False)]
    assert admitted(sent) == sent


@settings(deadline=None)  # a busy machine is no error
@given(st.lists(st.integers(0, 3 * PERIOD_NS), min_size=1, max_size=80))
def test_no_span_of_time_ever_carries_more_than_its_share_and_two_frames(steps):
    """The plain count: in any span, one frame per period begun, and the two of slack."""
    times = [sum(steps[: number + 1]) for number in range(len(steps))]
    taken = admitted(times)
    for first in range(len(taken)):
        for last in range(first, len(taken)):
            assert last - first + 1 <= (taken[last] - taken[first]) // PERIOD_NS + 3


def test_a_flood_gets_through_at_its_cyclic_rate_and_the_other_frames_are_not_held_up():
    assert len(admitted(range(0, 1000 * MS, MS // 10))) == 1000 * MS // PERIOD_NS + 2
    state = Sending()
    for _ in range(100):
        state, refusal = admit(state, command(), 0, PERMITS)
    assert refusal == "too soon"
    assert admit(state, CODEC.encode_command(BRAKING, Mode.REMOTE, False, 0)[1], 0, PERMITS)[1] == ""
    assert admit(state, command(), PERIOD_NS, PERMITS)[1] == "", "what was refused took no slot"


def test_three_frames_at_one_instant_pass_and_the_fourth_when_a_period_is_over():
    assert admitted([0, 0, 0, 0, PERIOD_NS - 1, PERIOD_NS, PERIOD_NS]) == [0, 0, 0, PERIOD_NS]


class Nobody:
    """No link: what arrives from the car goes nowhere."""

    def on_frame(self, frame: Frame, received_ns: int) -> None: ...


def test_the_gateway_s_bus_refuses_and_counts_by_identifier_and_the_rest_of_the_bus_hears_none_of_it():
    vehicle = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
    virtual, heard = CanSettings(interface="virtual", channel="transmit"), queue.Queue()
    car: CarBus = car_bus_of(virtual, vehicle)
    with (
        open_bus(virtual, "vehicle", lambda frame, _: heard.put(frame), Clock()) as other,
        open_car(virtual, car, Nobody(), Clock(), 0) as bus,
    ):
        foreign = Frame(0x2E4, bytes(5))
        broken = command()._replace(data=bytes(7))
        assert [bus.send(frame) for frame in (foreign, broken, foreign, command(1))] == [False, False, False, True]
        assert heard.get(timeout=5.0) == command(1), "the first that the others hear"
        assert bus.dropped == {"can not sent 0x2e4: not on the list": 2, "can not sent 0x100: wrong protection": 1}
        assert other.send(foreign), "who stands in for a car sends what it likes"


def test_the_codec_starts_with_no_feedback():
    assert CODEC.start() == FeedbackState()


def test_commands_are_admitted_in_every_cycle_and_each_frame_counts_for_itself():
    sent, sending = Sent(), Sending()
    for number in range(40):
        now_ns = number * SHORTEST_NS
        sent, frames = CODEC.commands(sent, BRAKING, Mode.REMOTE, False, None, now_ns)
        assert frames == CODEC.encode_command(BRAKING, Mode.REMOTE, False, number)
        for frame in frames:
            sending, refusal = admit(sending, frame, now_ns, PERMITS)
            assert refusal == ""
