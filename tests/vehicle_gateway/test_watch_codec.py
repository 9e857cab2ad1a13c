"""The watchdog's two frames: what they carry, who may send which, and what a dropped one changes."""

import pytest

from vehicle_gateway.can.e2e import Trail
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts
from vehicle_gateway.can.transmit import permits_of
from vehicle_gateway.can.watch_codec import SHIPPED, Fault, StopState, WatchCodec, decode_stop, watch_codec_of

FRAMES = layouts()
SOURCES, STOP = FRAMES["GATEWAY_SOURCES"], FRAMES["WATCHDOG_STOP"]


ROUND_MS = 65_535


@pytest.mark.parametrize(
    ("newest_ns", "told_ms"),
    [(0, 0), (999_999, 0), (1_000_000, 1), ((ROUND_MS - 1) * 1_000_000, ROUND_MS - 1), (ROUND_MS * 1_000_000, 0)],
)
def test_the_sources_are_told_in_milliseconds_that_go_round(newest_ns: int, told_ms: int) -> None:
    assert SOURCES.receive(SHIPPED.encode_sources(newest_ns, 7)) == (Trail(7), (told_ms,), "")


@pytest.mark.parametrize("fault", Fault)
def test_every_fault_arrives_as_itself(fault: Fault) -> None:
    assert decode_stop(StopState(), SHIPPED.encode_stop(fault, 3)) == (StopState(fault, Trail(3)), "")


def test_faults_have_the_numbers_that_the_dbc_names() -> None:
    assert [(fault.name, fault.value) for fault in Fault] == [
        ("NONE", 0),
        ("SILENT", 1),
        ("UNDRIVEN", 2),
        ("LEFT_STOP", 3),
        ("STARVED", 4),
    ]


def test_nothing_received_is_no_fault() -> None:
    assert StopState() == StopState(Fault.NONE, Trail(None, None, 0))


def test_a_dropped_frame_takes_no_fault_back() -> None:
    asked, _ = decode_stop(StopState(), SHIPPED.encode_stop(Fault.SILENT, 3))
    old, reason = decode_stop(asked, SHIPPED.encode_stop(Fault.NONE, 1))
    assert (old, reason) == (StopState(Fault.SILENT, Trail(3, 1, 1)), "can counter")
    broken, reason = decode_stop(asked, Frame(STOP.arbitration_id, bytes(STOP.size)))
    assert (broken, reason) == (asked, "can crc")


def test_each_of_the_two_may_send_its_own_frame_alone() -> None:
    assert SHIPPED.gateway_permits == permits_of((SOURCES,))
    assert SHIPPED.watchdog_permits == permits_of((STOP,))


def test_it_speaks_of_its_two_frames_alone() -> None:
    spoken = [name for name, layout in FRAMES.items() if SHIPPED.speaks(layout.pack([0.0] * len(layout.fields), 0))]
    assert sorted(spoken) == ["GATEWAY_SOURCES", "WATCHDOG_STOP"]


def test_a_car_whose_dbc_lacks_one_of_them_has_none() -> None:
    assert watch_codec_of(FRAMES) == WatchCodec(SOURCES, STOP) == SHIPPED
    for name in ("GATEWAY_SOURCES", "WATCHDOG_STOP"):
        assert watch_codec_of({other: layout for other, layout in FRAMES.items() if other != name}) is None
