from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import gateway_status
from tower.cockpit.lease_client import Lease, answered, asked, contradicts, due, request, with_epoch
from wire.messages.session import LeaseReply
from wire.messages.vehicle import GatewayStatus, Succession

S = 1_000_000_000


def reply(epoch: int = 3, granted: bool = True, boot_id: str = "b", key_hex: str = "ab" * 32) -> LeaseReply:
    return LeaseReply(
        granted=granted,
        epoch=epoch if granted else 0,
        key_hex=key_hex if granted else "",
        rule="" if granted else "held by another",
        boot_id=boot_id,
    )


def status(epoch: int = 3, holder: str = "o", boot_id: str = "b") -> GatewayStatus:
    return gateway_status(boot_id=boot_id, lease_holder=holder, lease_epoch=epoch)


def held(at_ns: int = 0) -> Lease:
    return answered(asked(Lease(), at_ns), reply(), at_ns)


def test_it_is_asked_for_at_start_each_second_until_granted_and_well_before_five_silent_seconds_after() -> None:
    lease, asked_s = Lease(), []
    for tenth in range(200):
        now = tenth * S // 10
        if due(lease, None, "o", now):
            asked_s.append(tenth / 10)
            lease = answered(asked(lease, now), reply(granted=len(asked_s) > 3), now)
    assert asked_s == [0.0, 1.0, 2.0, 3.0, *(3.0 + 1.5 * number for number in range(1, 12))]


def test_a_refusal_says_why_and_no_answer_takes_nothing_from_a_lease_that_is_held() -> None:
    assert answered(Lease(), reply(granted=False), 0).note == "held by another"
    assert answered(Lease(), None, 0).note == "the car does not answer"
    assert answered(held(), None, S).epoch == 3
    assert answered(held(), reply(granted=False), S).epoch == 0


def test_the_next_operator_s_own_lease_is_no_contradiction_as_long_as_the_car_speaks_of_it() -> None:
    lease, driven = held(), status(epoch=2, holder="ann")
    named = replace(driven, succession=Succession(operator="o", lease_epoch=3))
    assert not contradicts(lease, named, "o", S)
    for other in (driven, replace(named, succession=Succession(operator="o", lease_epoch=4)), replace(named, boot_id="c")):
        assert contradicts(lease, other, "o", S)


def test_another_boot_holder_or_epoch_is_asked_about_once_it_is_older_than_the_way_of_a_message() -> None:
    lease = held()
    for other in (status(epoch=4), status(epoch=2), status(holder="p"), status(boot_id="c")):
        assert not contradicts(lease, other, "o", S // 5)
        assert contradicts(lease, other, "o", S) and due(lease, other, "o", S)
    assert not due(lease, status(), "o", S)


def test_a_granted_hand_over_brings_the_new_epoch_and_the_key_stays() -> None:
    lease = with_epoch(held(), 4, S)
    assert (lease.epoch, lease.key) == (4, bytes.fromhex("ab" * 32))
    assert with_epoch(lease, 3, S).epoch == 4


def test_a_key_that_is_none_is_no_lease() -> None:
    assert not answered(Lease(), reply(key_hex="xyz"), 0).held


def test_the_same_session_is_named_every_time() -> None:
    assert request("o", "s", status(), 5).session == request("o", "s", status(), 9).session == "s"


def test_a_question_names_the_car_s_own_newest_stamp_and_start() -> None:
    asked_now = request("o", "s", replace(status(boot_id="b7"), stamp_ns=42), 5)
    assert (asked_now.echoed_vehicle_ns, asked_now.echoed_boot_id) == (42, "b7")


@given(grants=st.lists(st.integers(1, 100), max_size=30))
def test_hand_overs_never_lead_back_to_an_older_epoch(grants: list[int]) -> None:
    lease = held()
    for epoch in grants:
        before, lease = lease.epoch, with_epoch(lease, epoch, 0)
        assert lease.epoch >= before
