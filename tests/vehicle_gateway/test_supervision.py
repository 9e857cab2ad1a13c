"""The supervisor's orders and the end of a certificate, through whole gateway cycles: who drives then is as the table says."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from tests import messages
from tests.messages import drive_command
from vehicle_gateway.authority import Authority
from vehicle_gateway.cycle import step
from vehicle_gateway.gateway import recalled_state, remember
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import Lease
from vehicle_gateway.reports import status_of
from vehicle_gateway.state import GatewayLimits, Inputs, Picture, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.session import LeaseRequest, Supervision, SupervisionRequest
from wire.messages.vehicle import Mode, VehicleDescription

M, A = Mode, Supervision
S, MS = 10**9, 10**6
NOW = 5000 * S
CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LIMITS = GatewayLimits()
CHIEF = Identity(name="tower-supervisor.carla", operator="carla", fingerprint="c0", ends_ns=NOW + 10**6 * S)
TOWER = Identity(name="tower-hub", fingerprint="aa", ends_ns=NOW + 10**6 * S)
MOVING = messages.feedback(speed_m_s=3.0)
COMMAND = drive_command(lease_epoch=7, sent_ns=1, event_ns=1, echoed_vehicle_ns=NOW, echoed_boot_id="boot", acceleration_m_s2=0.5)


class Car:
    """A gateway in any mode, ann holding its lease; cycles of 10 ms."""

    def __init__(self, mode: Mode = M.STANDBY, speed_m_s: float = 0.0, ends_ns: int = TOWER.ends_ns, origin: Mode | None = None):
        self.now = NOW
        feedback = replace(MOVING, speed_m_s=speed_m_s)
        self.state = replace(
            initial_state("boot", NOW, 100, False),
            authority=Authority(mode=mode, origin=origin or mode),
            lease=Lease(epoch=107, holder="ann", session="s1", seen_ns=NOW, certificate="tower-hub", ends_ns=ends_ns),
            feedback=feedback,
            feedback_ns=NOW,
            command=COMMAND,
            command_ns=NOW,
            dead_man_ns=NOW,
            pictures={camera.name: Picture(capture_ns=NOW, advanced_ns=NOW) for camera in CAR.cameras},
            granted_ns=NOW,
        )
        self.feedback = feedback

    def cycle(self, dt_ms: int = 10, **inputs):
        self.now += dt_ms * MS
        self.state, self.out = step(self.state, Inputs(feedback=self.feedback, **inputs), self.now, CAR, LIMITS)
        return self

    def order(self, action: Supervision, asker: Identity = CHIEF, **changes):
        asked = SupervisionRequest(
            action=action,
            lease_epoch=self.state.lease.epoch,
            operator="",
            reason="he is tired",
            stop=False,
            sent_ns=1,
            echoed_vehicle_ns=self.now,
            echoed_boot_id="boot",
        )
        self.cycle(supervision_requests=(replace(asked, **changes),), supervisors=(asker,))
        return self.out.supervision_replies[0]

    def lease(self, operator: str, session: str = "s2", asker: Identity = TOWER):
        asked = LeaseRequest(
            operator=operator, session=session, sent_ns=1, echoed_vehicle_ns=self.now, echoed_boot_id=self.state.boot_id
        )
        self.cycle(lease_requests=(asked,), operators=(asker,))
        return self.out.lease_replies[0]

    def told(self):
        return status_of(self.state, self.now, CAR, LIMITS, {})


AFTER_REVOKE = {  # the architecture: driving source lost is a safe stop, receiving source lost ends the hand-over
    M.REMOTE: M.SAFE_STOP,
    M.HANDING_BACK: M.SAFE_STOP,
    M.HANDING_OVER: M.STANDBY,  # where it came from: nobody drove, the brakes were held
}


@pytest.mark.parametrize("mode", [M.STANDBY, M.HANDING_OVER, M.REMOTE, M.HANDING_BACK, M.STOPPED])
def test_a_revoked_lease_is_nobody_s_and_whoever_drove_with_it_makes_a_safe_stop(mode: Mode):
    car = Car(
        mode, speed_m_s=3.0 if mode in (M.REMOTE, M.HANDING_BACK) else 0.0, origin=M.STANDBY if mode is M.HANDING_OVER else mode
    )
    reply = car.order(A.REVOKE, stop=True)
    assert (reply.done, reply.rule) == (True, "")
    assert car.state.authority.mode is AFTER_REVOKE.get(mode, mode)
    assert car.state.lease.holder == "" and car.state.lease.epoch == 108
    assert car.state.command is None
    note = "carla took the lease from ann: he is tired"
    assert car.told().lease_note == note
    if car.state.authority.mode is M.SAFE_STOP:
        assert car.told().cause == note
        assert car.out.applied.hazard or car.cycle().out.applied.hazard


def test_what_became_of_a_hand_over_is_told_with_the_rule_on_the_car_s_side_too():
    revoked = Car(M.HANDING_OVER, origin=M.STANDBY)
    revoked.order(A.REVOKE, stop=True)
    late = Car(M.HANDING_OVER, origin=M.STANDBY).cycle(310)
    stopped = Car(M.HANDING_OVER, origin=M.STANDBY).cycle(stop_number=3)
    told = [(car.told().hand_over.state, car.told().hand_over.rule) for car in (revoked, late, stopped)]
    assert told == [
        ("aborted", "carla took the lease from ann: he is tired"),
        ("expired", "the hand-over was not completed in time"),
        ("aborted", "STOP was pressed in the tower"),
    ]


def test_nothing_of_the_old_holder_counts_after_it():
    car = Car(M.REMOTE, speed_m_s=3.0)
    car.order(A.REVOKE, stop=True)
    car.cycle(command=replace(COMMAND, lease_epoch=107, acceleration_m_s2=2.0), command_ns=car.now)
    assert car.state.command is None
    assert not car.lease("ann", "s1").granted


def test_a_driver_is_stopped_only_by_a_supervisor_who_says_so():
    car = Car(M.REMOTE, speed_m_s=3.0)
    assert "add --stop" in car.order(A.REVOKE).rule
    assert car.state.authority.mode is M.REMOTE and car.state.lease.holder == "ann"


def test_the_revoked_operator_waits_ten_minutes_or_until_he_is_let_in_and_others_need_not():
    car = Car()
    car.order(A.REVOKE)
    refused = car.lease("ann")
    assert not refused.granted and "600 s" in refused.rule
    car.cycle(599 * 1000)
    assert not car.lease("ann").granted
    assert car.order(A.ADMIT, operator="ann").done
    assert car.lease("ann").granted
    other = Car()
    other.order(A.REVOKE)
    assert other.lease("bob").granted
    late = Car()
    late.order(A.REVOKE)
    assert late.cycle(600 * 1000).lease("ann").granted


def test_the_named_operator_comes_first_for_half_a_minute():
    car = Car()
    car.order(A.REVOKE, operator="bob")
    assert "bob" in car.lease("eve").rule
    assert car.lease("bob").granted
    never = Car()
    never.order(A.REVOKE, operator="bob")
    assert never.cycle(30 * 1000).lease("eve").granted


def test_a_grant_clears_what_was_told_of_the_last_holder():
    car = Car()
    car.order(A.REVOKE)
    assert car.told().lease_note
    car.lease("bob")
    assert car.told().lease_note == ""


def test_after_three_stops_a_supervisor_releases_the_standing_car():
    car = Car(M.STOPPED)
    car.state = replace(car.state, stops=(NOW - 3 * S, NOW - 2 * S, NOW - S))
    assert "supervisor" in car.told().take_refused
    assert car.order(A.RELEASE, reason="looked at it").done
    assert car.told().stops_in_ten_minutes == 0
    assert "supervisor" not in car.told().take_refused
    assert car.told().lease_note == "released by carla: looked at it"
    assert car.state.authority.mode is M.STOPPED, "a release alone moves nothing"


@pytest.mark.parametrize("mode", [mode for mode in M if mode not in (M.STOPPED, M.STANDBY, M.HANDING_OVER)])
def test_a_car_that_does_not_stand_is_not_released(mode: Mode):
    car = Car(mode, speed_m_s=3.0)
    car.state = replace(car.state, stops=(NOW - S,))
    assert car.order(A.RELEASE).rule == "only a standing car is released"
    assert NOW - S in car.state.stops


@pytest.mark.parametrize(
    ("asker", "changes", "words"),
    [
        (Identity(rule="no certificate"), {}, "no certificate"),
        (Identity(), {}, "not signed"),
        (CHIEF, {"echoed_boot_id": "another car"}, "too old"),
        (CHIEF, {"echoed_vehicle_ns": NOW - S}, "too old"),
        (CHIEF, {"echoed_vehicle_ns": NOW + S}, "too old"),
        (CHIEF, {"lease_epoch": 106}, "ann holds it now"),
        (CHIEF, {"reason": ""}, "reason"),
        (CHIEF, {"operator": "ann"}, "holds it already"),
    ],
)
def test_every_order_that_is_none_is_refused_with_its_rule_and_changes_nothing(asker: Identity, changes: dict, words: str):
    car = Car()
    before = car.state.lease
    reply = car.order(A.REVOKE, asker, **changes)
    assert not reply.done and words in reply.rule
    assert car.state.lease == before and car.state.barred == {}


def test_an_order_that_is_heard_twice_is_obeyed_once():
    """Whoever repeats a supervisor's question within the half second it is fresh finds it answered."""
    car = Car()
    asked = {"echoed_vehicle_ns": car.now, "operator": "ann"}
    car.state = replace(car.state, barred={"ann": NOW + 600 * S})
    assert car.order(A.ADMIT, **asked).done
    car.state = replace(car.state, barred={"ann": NOW + 600 * S})
    assert car.order(A.ADMIT, **asked).rule == "this question was answered before"
    assert "ann" in car.state.barred


def test_nobody_is_let_in_who_was_not_kept_out_and_nothing_is_revoked_that_nobody_holds():
    car = Car()
    assert "not kept out" in car.order(A.ADMIT, operator="bob").rule
    car.state = replace(car.state, lease=Lease(epoch=5))
    assert car.order(A.REVOKE).rule == "nobody holds the lease"


def test_who_was_kept_out_is_so_after_a_restart_of_the_gateway():
    car = Car()
    car.order(A.REVOKE)
    utc = 1_700_000_000 * S
    again = recalled_state(remember(car.state, 1_000_000, utc), "boot", NOW // 2, utc + car.now - NOW // 2)
    car.state, car.now = replace(again, feedback=MOVING), NOW // 2
    assert not car.lease("ann").granted
    assert car.lease("bob").granted


def test_a_lease_ends_ten_seconds_before_its_certificate_and_a_drive_with_it_in_a_safe_stop():
    car = Car(M.REMOTE, speed_m_s=3.0, ends_ns=NOW + 12 * S)
    for _ in range(199):  # a command in every cycle: nothing else ends this drive
        command = replace(COMMAND, lease_epoch=107, displayed_capture_ns={"front": car.now})
        car.cycle(command=command, command_ns=car.now)
    assert (car.state.authority.mode, car.state.lease.holder) == (M.REMOTE, "ann")
    assert car.told().certificate_left_s == pytest.approx(10.01)
    car.cycle(command=command, command_ns=car.now)
    assert car.state.authority.mode is M.SAFE_STOP
    assert car.told().cause == car.told().lease_note == "the certificate of ann expires, or the car's"
    assert car.state.lease.holder == ""


@pytest.mark.parametrize("mode", [M.STANDBY, M.REMOTE])
def test_a_revoked_certificate_ends_the_lease_and_a_drive_with_it(mode: Mode):
    car = Car(mode, speed_m_s=3.0 if mode is M.REMOTE else 0.0).cycle(holder_revoked=True)
    assert car.state.authority.mode is AFTER_REVOKE.get(mode, mode)
    assert (car.state.lease.holder, car.told().lease_note) == ("", "the certificate of ann was revoked")
    assert car.cycle(holder_revoked=True).state.lease.epoch == 108, "it ends once"


def test_no_lease_is_granted_on_a_certificate_that_ends_now_and_no_take_on_one_that_ends_soon():
    soon = replace(TOWER, ends_ns=NOW + 9 * S)
    assert "renew" in Car().cycle().lease("ann", "s1", soon).rule
    for left_s, refused in ((899, True), (902, False)):
        car = Car()
        car.lease("ann", "s1", replace(TOWER, ends_ns=NOW + left_s * S))
        assert ("renew them" in car.told().take_refused) == refused


def test_a_personal_certificate_is_good_for_its_operator_alone_and_two_towers_are_told_apart():
    own = replace(TOWER, name="tower-hub.bob", operator="bob", fingerprint="bb")
    car = Car()
    car.state = replace(car.state, lease=Lease(epoch=100))
    assert "certificate of bob" in car.lease("ann", asker=own).rule
    assert car.lease("bob", "s1", own).granted
    assert (car.told().lease_certificate, car.told().lease_fingerprint) == ("tower-hub.bob", "bb")
    car.cycle(600)  # the same name with another certificate is somebody else: five seconds, not a half
    assert "5 s" in car.lease("bob", "s2", TOWER).rule
    assert car.lease("bob", "s3", own).granted
    renewed = replace(own, fingerprint="b2")
    assert car.lease("bob", "s3", renewed).granted, "a renewed certificate of the same name goes on"
    assert car.told().lease_fingerprint == "b2"


def test_a_lease_is_asked_for_with_a_fresh_stamp_of_this_car_and_a_renewal_may_wait_out_a_blackout():
    car = Car()
    car.state = replace(car.state, lease=Lease(epoch=100))
    fresh = LeaseRequest(operator="bob", session="s1", sent_ns=1, echoed_vehicle_ns=NOW, echoed_boot_id="boot")

    def asked(**changes) -> str:
        car.cycle(lease_requests=(replace(fresh, **changes),), operators=(TOWER,))
        return car.out.lease_replies[0].rule

    assert "too old" in asked(echoed_vehicle_ns=NOW - S)
    assert "too old" in asked(echoed_vehicle_ns=NOW + S)
    assert "too old" in asked(echoed_boot_id="another car")
    assert asked() == ""
    assert asked(echoed_vehicle_ns=NOW - 4 * S) == ""
    assert "too old" in asked(echoed_vehicle_ns=NOW - 5 * S)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["revoke", "admit", "ann", "bob", "wait"]), st.integers(1, 400)), max_size=25))
def test_whatever_is_ordered_nobody_holds_a_lease_while_he_is_kept_out_and_epochs_only_rise(story):
    car, until = Car(), dict[str, int]()
    for what, seconds in story:
        epoch, holder = car.state.lease.epoch, car.state.lease.holder
        match what:
            case "revoke":
                if car.order(A.REVOKE).done:
                    until[holder] = car.now + 600 * S
            case "admit":
                if car.order(A.ADMIT, operator="ann").done:
                    until.pop("ann")
            case "wait":
                car.cycle(seconds * 1000)
            case operator:
                car.lease(operator, f"of {operator}")
        assert car.state.lease.epoch >= epoch
        now_holds = car.state.lease.holder
        assert not now_holds or car.now >= until.get(now_holds, 0)
