"""The lease and its fence: one holder at a time, epochs that only rise, and no command passes that is not the holder's newest."""

from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import drive_command
from vehicle_gateway.lease import CommandGuard, Lease, refuse_command, renew_epoch, request_lease, without_holder
from wire.messages.session import LeaseRequest

S = 1_000_000_000
NOW = 3_600 * S
GUARD = CommandGuard(epoch=7, boot_id="boot", last_sequence=40)
GOOD = drive_command(lease_epoch=7, sequence=41, sent_ns=1, event_ns=1, echoed_vehicle_ns=NOW - S // 10, echoed_boot_id="boot")
HELD = Lease(epoch=7, holder="ann", session="s1", seen_ns=NOW)


def ask(operator: str, session: str) -> LeaseRequest:
    return LeaseRequest(operator=operator, session=session, sent_ns=0)


REQUESTS = st.builds(ask, st.sampled_from(["ann", "bob", "eve"]), st.sampled_from(["s1", "s2", "s3"]))


@given(st.lists(st.tuples(REQUESTS, st.integers(0, 6 * S), st.booleans(), st.booleans()), max_size=30))
def test_every_new_holder_gets_a_higher_epoch_than_all_before(steps):
    lease, now, used, holders = Lease(epoch=100), NOW, {100}, []
    for request, pause, in_use, renew in steps:
        now += pause
        before = lease
        lease, rule = request_lease(lease, request, now, in_use)
        if rule:
            assert lease == before
        elif (lease.holder, lease.session) != (before.holder, before.session):
            assert lease.epoch > max(used)
            assert not (in_use and before.holder), "the lease of a driving operator went to another"
        else:
            assert lease.epoch == before.epoch
        used.add(lease.epoch)
        if renew and lease.holder:
            lease = renew_epoch(lease)
            assert lease.epoch > max(used)
            used.add(lease.epoch)
        holders.append(lease.holder)


def test_an_epoch_that_was_given_to_the_next_operator_is_passed_over_also_after_a_renewal():
    beside = replace(HELD, given=11)
    renewed, _ = request_lease(beside, ask("ann", "s1"), NOW + S, in_use=True)
    assert (renewed.epoch, renew_epoch(renewed).epoch, without_holder(renewed)) == (7, 12, Lease(epoch=12))
    assert request_lease(renewed, ask("bob", "s2"), NOW + 9 * S, in_use=False)[0].epoch == 12


def test_a_first_request_is_granted_and_a_second_operator_is_told_who_holds_it():
    lease, rule = request_lease(Lease(), ask("ann", "s1"), NOW, in_use=False)
    assert (lease.holder, lease.epoch, rule) == ("ann", 1, "")
    same, rule = request_lease(lease, ask("bob", "s2"), NOW + S, in_use=False)
    assert same == lease
    assert "ann" in rule


def test_another_operator_waits_five_seconds_of_silence_and_a_restarted_tower_half_a_second():
    for operator, patience in (("bob", 5 * S), ("ann", S // 2)):
        assert request_lease(HELD, ask(operator, "s2"), NOW + patience - 1, in_use=False)[1] != ""
        assert request_lease(HELD, ask(operator, "s2"), NOW + patience, in_use=False)[0].epoch == 8


def test_nobody_gets_the_lease_of_an_operator_who_drives_whatever_the_silence():
    for operator in ("ann", "bob"):
        assert request_lease(HELD, ask(operator, "s2"), NOW + 3600 * S, in_use=True)[0] == HELD


def test_renewing_keeps_the_epoch_and_counts_as_a_sign_of_life():
    lease, rule = request_lease(HELD, ask("ann", "s1"), NOW + 4 * S, in_use=True)
    assert (lease.epoch, lease.seen_ns, rule) == (7, NOW + 4 * S, "")


def test_an_operator_without_a_name_gets_no_lease_since_nobody_could_be_told_who_holds_it():
    for session in ("", "s9"):
        lease, rule = request_lease(Lease(epoch=5), ask("", session), NOW, in_use=False)
        assert rule != ""
        assert lease.epoch == 5


def test_a_good_command_passes():
    assert refuse_command(GOOD, GUARD, True, NOW) == ""


def test_every_way_to_be_wrong_has_a_reason_of_its_own():
    wrong = [
        replace(GOOD, lease_epoch=6),
        replace(GOOD, lease_epoch=8),
        replace(GOOD, sequence=40),
        replace(GOOD, sequence=0),
        replace(GOOD, echoed_boot_id="other"),
        replace(GOOD, echoed_boot_id=""),
        replace(GOOD, echoed_vehicle_ns=NOW - S // 2 - 1),
        replace(GOOD, echoed_vehicle_ns=0),
        replace(GOOD, echoed_vehicle_ns=NOW + 1),
    ]
    reasons = [refuse_command(command, GUARD, True, NOW) for command in wrong]
    unsigned = refuse_command(GOOD, GUARD, False, NOW)
    assert all(reasons) and unsigned
    assert len({*reasons, unsigned}) == 6


def test_the_echo_may_be_exactly_half_a_second_old():
    assert refuse_command(replace(GOOD, echoed_vehicle_ns=NOW - S // 2), GUARD, True, NOW) == ""


@given(st.sampled_from([6, 7, 8]), st.integers(30, 50), st.sampled_from(["boot", "old"]), st.integers(-S, 2 * S), st.booleans())
def test_a_command_passes_only_if_everything_about_it_is_right(epoch, sequence, boot_id, echo_age, genuine):
    command = replace(GOOD, lease_epoch=epoch, sequence=sequence, echoed_boot_id=boot_id, echoed_vehicle_ns=NOW - echo_age)
    right = epoch == 7 and sequence > 40 and boot_id == "boot" and 0 <= echo_age <= S // 2 and genuine
    assert (refuse_command(command, GUARD, genuine, NOW) == "") == right


@given(st.lists(st.integers(0, 60), max_size=60))
def test_whatever_the_network_repeats_or_reorders_sequences_only_rise(sequences):
    guard, passed = GUARD, []
    for sequence in sequences:
        if not refuse_command(replace(GOOD, sequence=sequence), guard, True, NOW):
            guard = replace(guard, last_sequence=sequence)
            passed.append(sequence)
    assert all(a < b for a, b in zip([GUARD.last_sequence, *passed], passed, strict=False))
