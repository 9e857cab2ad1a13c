"""log_time and publish_time on one scale."""

from hypothesis import given
from hypothesis import strategies as st

from recordings.stamps import Clocks, publish_time_ns, stamp_field
from wire.topics import TOPICS

UTC_NS = 1_700_000_000_000_000_000
HOUR_NS = 3_600_000_000_000


@given(st.integers(0, 2**60), st.integers(0, 10**9), st.integers(-HOUR_NS, HOUR_NS))
def test_both_sites_stamps_of_one_moment_give_one_publish_time(vehicle_ns: int, late_ns: int, offset_ns: int) -> None:
    clocks = Clocks(utc_minus_vehicle_ns=UTC_NS, tower_offset_ns=offset_ns)
    log_ns = UTC_NS + vehicle_ns + late_ns
    from_car = publish_time_ns(vehicle_ns, log_ns, True, clocks)
    from_tower = publish_time_ns(vehicle_ns - offset_ns, log_ns, False, clocks)
    assert from_car == from_tower == log_ns - late_ns


def test_a_towers_stamp_before_its_offset_is_known_is_the_time_of_arrival() -> None:
    assert publish_time_ns(5, 77, False, Clocks(utc_minus_vehicle_ns=UTC_NS)) == 77


def test_a_message_without_a_stamp_was_published_when_it_arrived() -> None:
    assert publish_time_ns(None, 77, True, Clocks(utc_minus_vehicle_ns=UTC_NS)) == 77


def test_the_stamp_of_every_recorded_topic_is_found() -> None:
    found = {name: stamp_field(topic.type) for name, topic in TOPICS.items() if topic.recorded and topic.type}
    assert {name for name, field in found.items() if field is None} == {"vehicle_description", "road_map"}
    assert found["drive_command"] == found["tower_stop"] == "sent_ns"
    assert found["gateway_cycle"] == "now_ns"
    assert found["vehicle_state"] == "stamp_ns"
