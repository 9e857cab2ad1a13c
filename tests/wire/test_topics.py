"""The one table: every topic is said at one site, heard by somebody, recorded where it says so, and crosses only if it must."""

import pytest

from wire.topics import CAR, COCKPITS, QUERIES, TOPICS, TOWER, Kind, Role, Topic, Travel, key

ALL = pytest.mark.parametrize("topic", TOPICS.values(), ids=TOPICS)


def test_every_role_belongs_to_one_site():
    assert frozenset(Role) == CAR | TOWER
    assert not CAR & TOWER
    assert COCKPITS < TOWER


@ALL
def test_every_topic_is_said_at_exactly_one_site(topic: Topic):
    assert topic.publishers
    assert topic.publishers <= CAR or topic.publishers <= TOWER
    assert topic.origin_is_car == (topic.publishers <= CAR)


@ALL
def test_what_is_recorded_is_read_by_the_recorder_and_nothing_else_is(topic: Topic):
    assert topic.recorded == (Role.RECORDER in topic.readers)


@ALL
def test_a_topic_crosses_the_link_exactly_when_somebody_over_there_reads_it(topic: Topic):
    sites = [{"car" if role in CAR else "tower" for role in side} for side in (topic.publishers, topic.readers)]
    assert topic.crosses_link == bool(sites[1] - sites[0])


@ALL
def test_every_topic_has_a_reader(topic: Topic):
    assert topic.readers


def test_everything_the_tower_says_to_the_car_is_recorded_but_the_exchange_of_clocks():
    unrecorded = {topic.name for topic in TOPICS.values() if not topic.origin_is_car and topic.crosses_link and not topic.recorded}
    assert unrecorded == {"clock_ping"}


def test_the_truth_of_the_simulated_world_stays_with_those_who_may_see_it():
    world, referee = TOPICS["world_state"], TOPICS["referee"]
    assert world.readers == {Role.VIDEO}
    assert not world.recorded and not world.crosses_link and not referee.crosses_link
    assert referee.readers <= {Role.RECORDER, Role.CAR_OBSERVER}


def test_video_and_every_cycle_are_recorded_without_crossing_the_link():
    for name in ("video", "gateway_cycle"):
        assert TOPICS[name].recorded and not TOPICS[name].crosses_link


def test_only_cockpits_command_and_only_the_gateway_listens_besides_the_recorder():
    for name in ("drive_command", "tower_stop"):
        assert TOPICS[name].publishers == COCKPITS
        assert TOPICS[name].readers == {Role.VEHICLE_HUB, Role.RECORDER}


def test_only_the_authority_owns_the_mode():
    assert TOPICS["gateway_status"].publishers == {Role.VEHICLE_HUB}


def test_stop_is_an_event_on_a_reliable_key_and_a_command_is_a_level_that_is_rather_lost_than_late():
    stop, command = TOPICS["tower_stop"], TOPICS["drive_command"]
    assert (stop.kind, stop.travel) == (Kind.EVENT, Travel.EVENT)
    assert (command.kind, command.travel) == (Kind.LEVEL, Travel.COMMAND)


def test_names_are_their_own_keys_and_queries_share_none_with_topics():
    assert all(name == topic.name for name, topic in TOPICS.items())
    assert not set(TOPICS) & set(QUERIES)
    keys = [key("car-1", name) for name in (*TOPICS, *QUERIES)]
    assert len(set(keys)) == len(keys)
    assert not any(mark in each for each in keys for mark in "*$# ?")
    assert not set(keys) & {key("car-2", name) for name in (*TOPICS, *QUERIES)}


def test_the_car_answers_and_only_the_tower_asks_it():
    for query in QUERIES.values():
        assert query.server in CAR
        assert query.askers <= TOWER
    assert QUERIES["lease"].askers == QUERIES["hand_over"].askers == COCKPITS
