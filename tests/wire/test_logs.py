"""A line per event: for people, for a machine, never waited for, and told when lines were lost."""

import json
import logging
import re
from collections.abc import Iterator

import pytest

from wire import logs
from wire.logs import Format, fields, start, stop, tell_error, text_of

UTC = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z"
log = logging.getLogger("tests.wire.logs")


@pytest.fixture(autouse=True)
def ended() -> Iterator[None]:
    yield
    stop()


def test_a_line_for_people_has_time_process_level_event_and_what_it_is_about(capsys):
    start("vehicle-gateway run")
    log.info("mode", extra=fields(mode="safe_stop", cause="no CAN feedback", count=3))
    stop()
    assert re.fullmatch(
        UTC + ' process="vehicle-gateway run" level=info event=mode mode=safe_stop cause="no CAN feedback" count=3\n',
        capsys.readouterr().err,
    )


def test_a_line_for_a_machine_is_one_json_object_whatever_it_says(capsys):
    start("recordings record", Format.JSON)
    log.warning("camera %s: lost", "front", extra=fields(path=logging, text='quoted "\n'))
    stop()
    (line,) = capsys.readouterr().err.splitlines()
    told = json.loads(line)
    assert (told["process"], told["level"], told["event"]) == ("recordings record", "warning", "camera front: lost")
    assert re.fullmatch(UTC, told["time"]) and told["text"] == 'quoted "\n'


def test_an_exception_is_one_object_with_its_traceback_beside_the_event(capsys):
    start("vehicle-gateway run", Format.JSON)
    try:
        raise ValueError("this")
    except ValueError:
        log.exception("ended by an error")
    stop()
    told = json.loads(capsys.readouterr().err)
    assert told["event"] == "ended by an error"
    assert told["traceback"].startswith("Traceback") and told["traceback"].endswith("ValueError: this")


@pytest.mark.parametrize(
    ("value", "shown"),
    [("", '""'), ("a b", '"a b"'), ("a=b", '"a=b"'), ('a"b', '"a\\"b"'), ("a\nb", '"a\\nb"'), (7, "7"), ("ä", "ä")],
)
def test_values_are_quoted_where_a_reader_could_take_them_for_two(value, shown):
    assert text_of({"time": "T", "key": value}) == f"T key={shown}"


def test_what_the_user_can_fix_is_plain_for_people_and_an_event_for_a_machine(capsys):
    start("vehicle-gateway run")
    tell_error("car.toml: do this")
    assert capsys.readouterr().err == "car.toml: do this\n"
    start("vehicle-gateway run", Format.JSON)
    tell_error("car.toml: do this")
    stop()
    told = json.loads(capsys.readouterr().err)
    assert (told["level"], told["event"]) == ("error", "car.toml: do this")


def test_starting_again_replaces_the_log_and_nothing_is_told_twice(capsys):
    start("one")
    start("two")
    log.info("here")
    stop()
    log.info("nobody listens")
    told = capsys.readouterr().err
    assert told.count("event=here") == 1 and "process=two" in told and "nobody listens" not in told


def test_a_flood_never_waits_and_what_was_lost_is_counted():
    waiting = logs._Bounded()
    record = logging.makeLogRecord({"msg": "flood"})
    for _ in range(logs.WAITING_MAX + 7):
        waiting.put_nowait(record)
    assert waiting.lost == 7
    waiting.put_nowait(None)
    told = [waiting.get() for _ in range(logs.WAITING_MAX + 1)]
    assert told[0] is not None and told[0].msg == "flood (and 7 records lost before)"
    assert told[-1] is None, "the end always fits"
