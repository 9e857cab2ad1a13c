"""Every key of the topic table, over the real link: what is wrong is dropped and counted, and what follows is heard.

Payloads are made from the message's type; that each is refused follows from a second, plainer rule: it differs from a valid
one in exactly the way its name says.
"""

import pytest

from benchmarks.examples import changed, encode_example, wrong
from wire.messages.base import decoder, encode
from wire.messages.health import LoopHealth
from wire.order import is_ordered
from wire.picture import EncodedPicture, pack_picture, unpack_picture
from wire.topics import CAR, COCKPITS, TOPICS, Kind, Role

TYPED = sorted(name for name, topic in TOPICS.items() if topic.type is not None)
ORDERED = [name for name in TYPED if TOPICS[name].kind is Kind.LEVEL and is_ordered(TOPICS[name].type)]
FLOOD = 300  # messages in one burst
KEPT = 16  # of them that a queue of this size may hold
TOO_LARGE = 1_000_001  # bytes: one more than the link takes


@pytest.mark.parametrize("name", TYPED)
def test_what_is_wrong_is_dropped_and_counted_and_what_follows_is_heard(world, name):
    speaker, listener, heard = world.speaker(name), world.listener(name), []
    listener.on(name, lambda message, _: heard.append(message))
    good = encode_example(name)
    world.until(lambda: heard, lambda: speaker.publish(name, good))
    for what, payload in wrong(name).items():
        with pytest.raises((ValueError, RecursionError)):
            decoder(TOPICS[name].type).decode(payload)
        counted = listener.dropped[f"{name} undecodable"]
        world.until(
            lambda counted=counted: listener.dropped[f"{name} undecodable"] > counted,
            lambda payload=payload: speaker.publish(name, payload),
        )
        assert set(map(encode, heard)) == {good}, what
    counted = len(heard)
    world.until(lambda: listener.dropped[f"{name} too large"], lambda: speaker.publish(name, b"x" * TOO_LARGE))
    world.until(lambda: len(heard) > counted, lambda: speaker.publish(name, good))
    assert set(map(encode, heard)) == {good}


def test_a_picture_that_is_none_is_told_apart_from_one_that_is(world):
    """Pictures cross as bytes; whoever reads them unpacks them."""
    whole = pack_picture(EncodedPicture(camera="front", capture_ns=1, sequence=1, is_idr=True, annex_b=b"\x00\x00\x00\x01\x65"))
    bad = (b"", b"\x00", whole[:10], whole[: whole.index(b"front")], whole.replace(b"front", b"fr\xffnt"))
    arrived: list[bytes] = []
    world.listener("video").on_raw("video", lambda _, payload, __: arrived.append(payload))
    for payload in (*bad, whole):  # each is sent until it has come: what was sent twice may come after the next was asked for
        world.until(
            lambda payload=payload: payload in arrived, lambda payload=payload: world.speaker("video").publish("video", payload)
        )
    for payload in bad:
        with pytest.raises(ValueError):
            unpack_picture(payload)
    assert unpack_picture(arrived[arrived.index(whole)]).camera == "front"


@pytest.mark.parametrize("name", ORDERED)
def test_what_is_repeated_or_overtaken_is_no_news(world, name):
    speaker, listener = world.speaker(name), world.listener(name)
    slot, good = listener.level(name), encode_example(name)

    def send(stamp_ns: int) -> None:
        speaker.publish(name, changed(good, stamp_ns=stamp_ns))

    def newest() -> int:
        received = slot.get()
        return received.message.stamp_ns if received else 0

    world.until(lambda: newest() == 2_000, lambda: send(2_000))
    old = listener.dropped[f"{name} out of order"]
    world.until(lambda: listener.dropped[f"{name} out of order"] > old, lambda: send(1_000))  # overtaken
    old = listener.dropped[f"{name} out of order"]
    world.until(lambda: listener.dropped[f"{name} out of order"] > old, lambda: send(2_000))  # repeated
    assert newest() == 2_000
    world.until(lambda: newest() == 2_001, lambda: send(2_001))


@pytest.mark.parametrize("name", TYPED)
def test_a_flood_fills_no_memory_and_what_follows_it_is_heard(world, name):
    speaker, listener, good = world.speaker(name), world.listener(name), encode_example(name)
    queue, stamps = listener.events(name, limit=KEPT), iter(range(10_000, 10_000_000))

    def send() -> None:
        speaker.publish(name, changed(good, stamp_ns=next(stamps)) if b'"stamp_ns"' in good else good)

    def flood() -> None:
        for _ in range(FLOOD):
            send()

    world.until(lambda: queue.refused > FLOOD, flood)
    assert len(queue.drain()) == KEPT
    world.until(queue.drain, send)


@pytest.mark.parametrize("name", sorted(TOPICS))
def test_who_may_not_say_it_is_not_even_heard_at_the_hub(world, name):
    """Every wrong role says it, and then something it may say; when that has arrived, still only the right role's has."""
    arrived: list[bytes] = []
    healthy: set[str] = set()
    good = encode_example(name) if TOPICS[name].type else b"right"
    for hub in (Role.VEHICLE_HUB, Role.TOWER_HUB):
        world.link(hub).on_raw(name, lambda _, payload, __: arrived.append(payload))
        for health in ("car_health", "tower_health"):
            world.link(hub).on(health, lambda message, _: healthy.add(message.process))
    strangers = [role for role in Role if role not in TOPICS[name].publishers | {Role.VEHICLE_HUB, *COCKPITS}]

    def speak() -> None:
        for role in strangers:
            world.link(role).publish(name, b"wrong")
            world.link(role).publish(health_of(role), alive(f"{role} {name}"))
        world.speaker(name).publish(name, good)

    heard = {f"{role} {name}" for role in strangers if role in TOPICS[health_of(role)].publishers}  # an observer says nothing
    world.until(lambda: heard <= healthy and good in arrived, speak)
    speak()
    before = len(arrived)
    world.until(lambda: len(arrived) > before, lambda: world.speaker(name).publish(name, good))
    assert b"wrong" not in arrived


def health_of(role: Role) -> str:
    return "car_health" if role in CAR else "tower_health"


def alive(process: str) -> LoopHealth:
    return decoder(LoopHealth).decode(changed(encode_example("car_health"), process=process, dropped={}))
