"""What of the gateway's cycles goes into the audit trail: cycles made up by hand, so that what happened is known beforehand."""

from math import cos, radians

from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.audit.episodes import OPEN_MAX, Seen, follow_up
from vehicle_gateway.audit.position import MapOrigin, degrees_of
from vehicle_gateway.audit.trail import About, Trail, observe, start
from vehicle_gateway.authority import Authority
from vehicle_gateway.failsafe import Cause
from vehicle_gateway.identity import Identity
from vehicle_gateway.journal import Entry
from vehicle_gateway.lease import Lease
from vehicle_gateway.state import Inputs, Outputs, State, Successor, initial_state
from wire.messages.audit import AuditEntry, AuditKind
from wire.messages.automation import Scene
from wire.messages.session import (
    Action,
    HandOverReply,
    HandOverRequest,
    LeaseReply,
    LeaseRequest,
    Outcome,
    Supervision,
    SupervisionReply,
    SupervisionRequest,
)
from wire.messages.vehicle import Actuation, HandOver, Mode

K, M = AuditKind, Mode
START_NS, CYCLE_NS = 5_000_000_000, 10_000_000
ABOUT = About(vehicle_id="car-1", boot_id="boot", utc_minus_now_ns=1_700_000_000_000_000_000)
CALM = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
NOTHING = Inputs()
HELD = Lease(epoch=7, holder="ann", session="s1")


class Story:
    """One gateway, cycle by cycle; everything it told."""

    def __init__(self, about: About = ABOUT) -> None:
        self.trail, self.about, self.told = Trail(), about, list[AuditEntry]()
        self.state: State = initial_state("boot", START_NS, 100, False)
        self.now_ns = START_NS

    def cycle(self, mode: Mode | None = None, inputs: Inputs = NOTHING, **changes: object) -> list[AuditEntry]:
        """One cycle; changes of the state by name, of the outputs with `out_` before it."""
        self.now_ns += CYCLE_NS
        before = self.state
        to = mode or before.authority.mode
        fields = {name: value for name, value in changes.items() if not name.startswith("out_")}
        self.state = replace(before, now_ns=self.now_ns, authority=Authority(mode=to, origin=to), **fields)
        given = {name.removeprefix("out_"): value for name, value in changes.items() if name.startswith("out_")}
        plain = {"requested": CALM, "applied": CALM, "rules": (), "causes": ()}
        outputs = Outputs(send=True, mode=to, brake_hold=False, cap_m_s=8.0, **({"events": ()} | plain | given))
        self.trail, entries = observe(self.trail, Entry(1, self.now_ns, before, inputs, self.state, outputs, 0), self.about)
        self.told += entries
        return list(entries)

    def run(self, cycles: int, **changes: object) -> list[AuditEntry]:
        return [entry for _ in range(cycles) for entry in self.cycle(**changes)]

    def kinds(self) -> list[AuditKind]:
        return [entry.kind for entry in self.told]


def scene(x_m: float, y_m: float, stamp_ns: int) -> Scene:
    return Scene(
        stamp_ns=stamp_ns,
        x_m=x_m,
        y_m=y_m,
        heading_rad=0.5,
        speed_m_s=3.0,
        yaw_rate_rad_s=0.0,
        deviation_m=0.12345,
        station_m=0.0,
        offset_m=0.0,
        objects=(),
        plan=(),
        stopping_corridor=(),
    )


def test_a_cycle_in_which_nothing_happens_tells_nothing():
    story = Story()
    assert story.run(1000) == []


def test_a_remote_drive_has_a_number_a_begin_an_end_and_the_causes_of_both():
    story = Story()
    story.cycle(lease=HELD)
    story.cycle(M.REMOTE, cause="ann took over")
    story.run(50)
    story.cycle(M.HANDING_BACK, cause="handing back")
    story.cycle(M.AUTONOMOUS, cause="handed back")
    begin, end = (next(entry for entry in story.told if entry.kind is kind) for kind in (K.DRIVE_BEGIN, K.DRIVE_END))
    assert (begin.drive, begin.operator, begin.text, begin.epoch) == (1, "ann", "ann took over", 7)
    assert (end.drive, end.operator, end.text) == (1, "ann", "handed back")
    assert end.stamp_ns - begin.stamp_ns == 52 * CYCLE_NS
    assert end.utc_ns - end.stamp_ns == ABOUT.utc_minus_now_ns
    assert not end.remote and begin.remote
    story.cycle(M.REMOTE, cause="again")
    assert story.told[-1].drive == 2


BOB = Successor(operator="bob", lease=Lease(epoch=9, holder="bob", session="s2", fingerprint="bb"))


def test_where_another_operator_takes_over_one_drive_ends_and_the_next_begins_and_what_lasts_is_told_in_both():
    story = Story()
    story.cycle(lease=HELD)
    story.cycle(M.REMOTE, cause="ann took over")
    story.cycle(out_rules=("speed cap",), lease_note="eve lets bob take over", successor=BOB)
    entries = story.cycle(
        lease=BOB.lease,
        successor=Successor(),
        lease_note="",
        cause="bob took over from ann",
        inputs=Inputs(hand_over_requests=(question(1, Action.PASS_ON), question(1, Action.TAKE, epoch=9))),
        out_hand_over_replies=(answer(1), answer(1)),
        out_rules=("speed cap",),
        out_events=("operator_changed",),
    )
    assert [(entry.kind, entry.drive, entry.operator, entry.subject or entry.text) for entry in entries] == [
        (K.LEASE_LOST, 1, "ann", "eve lets bob take over"),
        (K.INTERVENTION_END, 1, "ann", "speed cap"),
        (K.DRIVE_END, 1, "ann", "bob took over from ann"),
        (K.DRIVE_BEGIN, 2, "bob", "bob took over from ann"),
        (K.LEASE, 2, "bob", ""),
        (K.GRANT, 2, "ann", "pass_on"),
        (K.GRANT, 2, "bob", "take"),
        (K.INTERVENTION, 2, "bob", "speed cap"),
    ]
    assert all(entry.remote for entry in entries)
    assert [e.drive for e in story.cycle(M.SAFE_STOP, cause="lost") if e.kind is K.DRIVE_END] == [2]


def test_what_the_next_operator_is_refused_is_told_under_his_name_and_that_he_did_not_take_over_with_why():
    story = Story()
    story.cycle(lease=HELD)
    story.cycle(M.REMOTE, cause="ann took over", successor=BOB)
    refused = answer(1, "align the wheel")
    entries = story.cycle(inputs=Inputs(hand_over_requests=(question(1, epoch=9),)), out_hand_over_replies=(refused,))
    assert [(e.kind, e.operator, e.subject, e.text) for e in entries] == [(K.REFUSAL, "bob", "take", "align the wheel")]
    over = story.cycle(successor=Successor(), lease_note="bob did not take over in time: ann drives on")
    assert [(e.kind, e.operator, e.subject, e.text) for e in over] == [
        (K.HAND_OVER, "bob", "expired", "bob did not take over in time: ann drives on")
    ]


def test_what_ends_a_drive_belongs_to_it_and_what_follows_does_not():
    story = Story()
    story.cycle(M.REMOTE, lease=HELD)
    story.cycle(M.SAFE_STOP, cause="no valid command from the tower", out_causes=(Cause.COMMAND_LOST,))
    after = story.cycle(out_rules=("jerk",))
    by_kind = {entry.kind: entry for entry in story.told}
    assert by_kind[K.FAILSAFE].remote and by_kind[K.FAILSAFE].drive == 1
    assert story.kinds()[-2:] == [K.DRIVE_END, K.INTERVENTION] and not after[0].remote


def test_numbers_go_on_after_a_restart_and_a_drive_that_was_never_ended_is_ended():
    story = Story()
    trail, entries = start(Trail(drive=41, remote=True, mode=M.REMOTE, operator="ann"), START_NS, ABOUT, "ours 1.0", "ab" * 32)
    assert [entry.kind for entry in entries] == [K.START, K.DRIVE_END]
    assert (entries[0].software, entries[0].configuration_sha256) == ("ours 1.0", "ab" * 32)
    assert (entries[1].drive, entries[1].operator) == (41, "ann") and "died" in entries[1].text
    story.trail = trail
    story.cycle(M.REMOTE, lease=HELD)
    assert story.told[-1].kind is not K.DRIVE_END and story.trail.drive == 42
    _, calm = start(Trail(drive=41), START_NS, ABOUT, "", "")
    assert [entry.kind for entry in calm] == [K.START]


def test_an_end_is_told_although_the_cycle_that_ended_the_drive_was_never_seen():
    story = Story()
    story.cycle(M.REMOTE, lease=HELD)
    story.state = replace(story.state, authority=Authority(mode=M.STOPPED, origin=M.STOPPED), cause="stands")
    assert [entry.kind for entry in story.cycle()] == [K.DRIVE_END]


def test_every_change_of_mode_is_told_once_with_its_cause_and_where_it_came_from():
    story = Story()
    for mode in M:
        story.cycle(mode, cause=f"to {mode}")
    told = [(entry.subject, entry.mode, entry.text) for entry in story.told if entry.kind is K.MODE]
    assert told == [(a.value, b, f"to {b}") for a, b in zip(list(M), list(M)[1:], strict=False)]


def test_a_lease_is_told_when_it_is_granted_and_lost_and_not_when_it_is_renewed():
    story = Story()
    story.cycle(lease=HELD)
    story.cycle(lease=replace(HELD, seen_ns=5), inputs=Inputs(lease_requests=(ask(),)), out_lease_replies=(leased(),))
    story.cycle(lease=Lease(epoch=8, holder="bob", session="s2"))
    story.cycle(lease=Lease(epoch=9))
    told = [(entry.kind, entry.operator, entry.epoch) for entry in story.told]
    assert told == [(K.LEASE, "ann", 7), (K.LEASE_LOST, "ann", 7), (K.LEASE, "bob", 8), (K.LEASE_LOST, "bob", 8)]


def ask(operator: str = "ann") -> LeaseRequest:
    return LeaseRequest(operator=operator, session="s", sent_ns=0)


def leased(rule: str = "") -> LeaseReply:
    return LeaseReply(granted=not rule, epoch=0, key_hex="", rule=rule, boot_id="boot")


def question(number: int, action: Action = Action.TAKE, epoch: int = 7) -> HandOverRequest:
    return HandOverRequest(lease_epoch=epoch, number=number, action=action, sent_ns=0)


def answer(number: int, rule: str = "") -> HandOverReply:
    return HandOverReply(number=number, outcome=Outcome.REFUSED if rule else Outcome.GRANTED, rule=rule, lease_epoch=8)


def test_a_refusal_is_told_at_once_with_its_rule_and_the_same_again_is_counted():
    story = Story()
    story.cycle(lease=HELD)
    refused = {"inputs": Inputs(lease_requests=(ask("bob"),)), "out_lease_replies": (leased("held by ann"),)}
    first = story.cycle(**refused)
    assert [(entry.kind, entry.subject, entry.operator, entry.text) for entry in first] == [
        (K.REFUSAL, "lease", "bob", "held by ann")
    ]
    for _ in range(9):
        assert story.run(99) + story.cycle(**refused) == []
    (over,) = story.run(400)
    assert (over.kind, over.operator, over.times) == (K.REFUSAL_END, "bob", 10)
    assert over.lasted_s == 9.0


def test_every_answer_to_a_hand_over_question_is_told_and_what_became_of_the_grant():
    story = Story()
    story.cycle(lease=HELD)
    story.cycle(inputs=Inputs(hand_over_requests=(question(1),)), out_hand_over_replies=(answer(1, "align the wheel"),))
    story.cycle(inputs=Inputs(hand_over_requests=(question(2),)), out_hand_over_replies=(answer(2),))
    granted = HandOver(number=1, action="take", state="granted", rule="", question=2)
    story.cycle(hand_over=granted)
    story.cycle(hand_over=replace(granted, state="expired"))
    told = [(entry.kind, entry.subject, entry.question, entry.text) for entry in story.told[1:]]
    assert told == [
        (K.REFUSAL, "take", 1, "align the wheel"),
        (K.GRANT, "take", 2, ""),
        (K.HAND_OVER, "expired", 2, "take"),
    ]


def test_an_intervention_is_two_records_however_long_it_lasts():
    """150 cycles of 10 ms with one rule; the strongest change in the middle."""
    story = Story()
    asked = replace(CALM, acceleration_m_s2=1.0)
    story.run(50, out_rules=("jerk",), out_requested=asked, out_applied=CALM)
    story.cycle(out_rules=("jerk",), out_requested=replace(CALM, acceleration_m_s2=2.0), out_applied=CALM)
    story.run(20)  # 0.2 s without it is the same episode
    story.run(79, out_rules=("jerk",), out_requested=asked, out_applied=CALM)
    story.run(100)
    begin, end = story.told
    assert (begin.kind, begin.subject, begin.requested) == (K.INTERVENTION, "jerk", asked)
    assert (end.kind, end.subject, end.times) == (K.INTERVENTION_END, "jerk", 130)
    assert end.lasted_s == 149 * CYCLE_NS / 1e9
    assert end.requested is not None and end.requested.acceleration_m_s2 == 2.0 and end.applied == CALM


def test_an_intervention_is_split_where_a_drive_begins_and_ends_so_that_each_drive_is_told_whole():
    story = Story()
    story.run(10, out_rules=("jerk",))
    story.cycle(M.REMOTE, lease=HELD, out_rules=("jerk",))
    story.run(4, out_rules=("jerk",))
    story.cycle(M.SAFE_STOP, out_rules=("jerk",))
    story.run(7, out_rules=("jerk",))
    story.run(100)
    ends = [(entry.times, entry.remote) for entry in story.told if entry.kind is K.INTERVENTION_END]
    assert ends == [(10, True), (6, True), (7, False)]
    assert [entry.remote for entry in story.told if entry.kind is K.INTERVENTION] == [False, True, False]


def test_a_stop_in_the_tower_and_a_failsafe_cause_that_goes_are_told():
    story = Story()
    story.cycle(inputs=Inputs(stop_number=3))
    story.run(3, out_causes=(Cause.COMMAND_SILENT,))
    story.run(100)
    assert story.kinds() == [K.STOP, K.FAILSAFE, K.FAILSAFE_END]
    assert story.told[0].question == 3
    assert (story.told[2].subject, story.told[2].times) == ("command_silent", 3)


def test_the_position_is_the_newest_scenes_with_its_age_and_degrees_only_with_an_origin():
    story = Story()
    story.cycle(inputs=Inputs(scene=scene(12.345, -3.0, START_NS)))
    (entry,) = (each for each in story.cycle(M.REMOTE, lease=HELD) if each.kind is K.DRIVE_BEGIN)
    assert entry.position is not None
    assert (entry.position.x_m, entry.position.y_m, entry.position.deviation_m) == (12.35, -3.0, 0.12)
    assert entry.position.age_s == 2 * CYCLE_NS / 1e9
    assert entry.position.latitude_deg is None
    placed = Story(about=replace(ABOUT, origin=MapOrigin(latitude_deg=52.5, longitude_deg=13.4, altitude_m=34.0)))
    placed.cycle(M.REMOTE, inputs=Inputs(scene=scene(0.0, 0.0, START_NS)), lease=HELD)
    position = placed.told[0].position
    assert position is not None
    assert (position.latitude_deg, position.longitude_deg, position.altitude_m) == (52.5, 13.4, 34.0)
    assert Story().cycle(M.REMOTE)[0].position is None


@given(st.floats(-60, 60), st.floats(-179.9, 179.9), st.floats(-2000, 2000), st.floats(-2000, 2000))
def test_degrees_agree_with_the_length_of_a_degree_on_the_ellipsoid(latitude: float, longitude: float, x_m: float, y_m: float):
    """The second rule: the published series of the length of a degree of latitude and of longitude."""
    found = degrees_of(x_m, y_m, MapOrigin(latitude_deg=latitude, longitude_deg=longitude))
    p = radians(latitude)
    north = y_m / (111132.92 - 559.82 * cos(2 * p) + 1.175 * cos(4 * p))
    east = x_m / (111412.84 * cos(p) - 93.5 * cos(3 * p) + 0.118 * cos(5 * p))
    assert abs(found[0] - latitude - north) < 2e-5
    assert abs((found[1] - longitude - east + 180.0) % 360.0 - 180.0) < 2e-5


@given(st.lists(st.tuples(st.integers(1, 800), st.sets(st.sampled_from("abc"))), max_size=60))
def test_whatever_comes_and_goes_every_begin_has_one_end_and_every_cycle_is_counted(cycles: list[tuple[int, set[str]]]):
    """Per subject, by a plainer rule: gaps of more than half a second split its cycles into episodes."""
    open_, now_ns, begun, over, at = (), 0, [], [], {name: list[int]() for name in "abc"}
    for pause_ms, names in [*cycles, (1000, set())]:
        now_ns += pause_ms * 1_000_000
        seen = tuple(Seen(K.INTERVENTION, name) for name in sorted(names))
        open_, began, ended = follow_up(open_, seen, now_ns)
        begun += began
        over += ended
        for name in names:
            at[name].append(now_ns)
    assert open_ == () and len(begun) == len(over)
    for name, times in at.items():
        splits = sum(b - a > 500_000_000 for a, b in zip(times, times[1:], strict=False))
        mine = [each for each in over if each.subject == name]
        assert sum(each.times for each in mine) == len(times)
        assert len(mine) <= splits + 1
        assert all(a.last_ns < b.first_ns for a, b in zip(mine, mine[1:], strict=False))


def test_a_flood_of_names_opens_no_more_episodes_than_there_is_room_for():
    seen = tuple(Seen(K.REFUSAL, "lease", "held by ann", f"operator {number}") for number in range(1000))
    open_, begun, _ = follow_up((), seen, 1)
    assert len(open_) == len(begun) == OPEN_MAX


def test_a_supervisor_s_order_is_told_with_who_gave_it_and_the_lease_that_it_took_with_whose_certificate_it_was():
    chief = Identity(name="tower-supervisor.carla", operator="carla", fingerprint="c" * 64)
    order = SupervisionRequest(
        action=Supervision.REVOKE,
        lease_epoch=7,
        operator="bob",
        reason="tired",
        stop=False,
        sent_ns=1,
        echoed_vehicle_ns=1,
        echoed_boot_id="boot",
    )
    story = Story()
    story.cycle(lease=replace(HELD, certificate="tower-hub", fingerprint="a" * 64))
    asked = Inputs(supervision_requests=(order,), supervisors=(chief,))
    story.cycle(inputs=asked, out_supervision_replies=(SupervisionReply(done=False, rule="no"),))
    story.cycle(
        inputs=asked,
        lease=Lease(epoch=8),
        lease_note="carla took it",
        out_supervision_replies=(SupervisionReply(done=True, rule=""),),
    )
    told = [(entry.kind, entry.operator, entry.certificate, entry.text) for entry in story.told]
    assert (K.LEASE, "ann", "a" * 64, "") in told
    assert (K.REFUSAL, "carla", "", "no") in told
    assert (K.ORDER, "carla", "c" * 64, "bob: tired") in told
    assert (K.LEASE_LOST, "ann", "a" * 64, "carla took it") in told
