"""Two commands between two cycles: the gateway drives by the newer, and remembers what the older told of the operator's screen."""

import pytest

from tests.safety.witness import watched
from tests.safety.world import AHEAD_NS, MS, World, led_to
from wire.messages.vehicle import Mode


def by_hand() -> World:
    """Remote, and commands arrive only when the test says so."""
    world = led_to(Mode.REMOTE, watched(World()))
    world.flying = []
    world.run(0.1).towers[0].silent = True
    world.flying = []
    return world.tick()


def arrives(world, shown_ns, *, before_cycle_ms) -> int:
    """A command with this picture, so long before the next cycle; when that was."""
    ann, at_ns = world.towers[0], world.now_ns + round((10.0 - before_cycle_ms) * MS)
    ann.frozen, ann.shown_ns, ann.clock_ns = True, shown_ns, at_ns + AHEAD_NS - 20 * MS
    world.arrive(ann, ann.command(world.angle), at_ns)
    return at_ns


def mode_when_blind_for(world, ms, first_ns) -> Mode:
    """The same picture with every command, the last of them exactly so long after the first that told of it."""
    shown_ns = world.towers[0].shown_ns
    while world.now_ns + 10 * MS < first_ns + ms * MS:
        arrives(world, shown_ns, before_cycle_ms=5.0)
        world.tick()
    arrives(world, shown_ns, before_cycle_ms=10.0 - (first_ns + ms * MS - world.now_ns) / MS)
    return world.tick().out.mode


@pytest.mark.parametrize("overtaken", [1, 2, 3])
@pytest.mark.parametrize(("ms", "mode"), [(200.0, Mode.REMOTE), (200.001, Mode.SAFE_STOP)])
def test_a_picture_counts_from_the_first_command_that_told_of_it(overtaken, ms, mode):
    world = by_hand()
    picture_ns = world.now_ns - 50 * MS
    first_ns, *_ = [arrives(world, picture_ns, before_cycle_ms=9.0 - k) for k in range(overtaken + 1)]
    world.tick()
    assert mode_when_blind_for(world, ms, first_ns) is mode


def test_a_newer_picture_in_the_overtaking_command_is_a_new_one():
    world = by_hand()
    arrives(world, world.now_ns - 50 * MS, before_cycle_ms=9.0)
    newer_ns = arrives(world, world.now_ns - 20 * MS, before_cycle_ms=0.0)
    world.tick()
    assert mode_when_blind_for(world, 200, newer_ns) is Mode.REMOTE


def test_a_stamp_that_was_of_the_future_when_it_came_first_counts_from_when_it_was_one_of_the_past():
    world = by_hand()
    arrives(world, world.now_ns + 5 * MS, before_cycle_ms=9.0)
    second_ns = arrives(world, world.now_ns + 5 * MS, before_cycle_ms=1.0)
    world.tick()
    assert mode_when_blind_for(world, 200, second_ns) is Mode.REMOTE
    assert world.state.pictures["front"].advanced_ns == second_ns
    assert world.state.pictures["front"].told_ns == second_ns + AHEAD_NS - 20 * MS


def test_what_was_taken_is_not_remembered_for_the_next_cycle():
    world = by_hand()
    arrives(world, world.now_ns - 50 * MS, before_cycle_ms=1.0)
    world.tick()
    arrives(world, world.now_ns - 20 * MS, before_cycle_ms=1.0)
    world.tick()
    assert world.inputs.told_ns == {}
