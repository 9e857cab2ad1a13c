"""What two operators see of one car that one of them drives: who drives it, and what to do when it shall change hands."""

from msgspec.structs import replace

from tests.tower.test_window_model import heard, operator, sights, state, status
from tower.window.drive_log import DriveLog
from tower.window.looks import Driver
from tower.window.view_model import view_model
from tower.window.views import ViewModel
from wire.messages.vehicle import GatewayStatus, Mode, Succession

NOBODY = Succession()
NAMED = Succession(operator="Ben", lease_epoch=8, agreed=False, refused="Anna has not passed the car on", remaining_s=30.0)
AGREED = replace(NAMED, agreed=True, refused="")


def driven(named: Succession = NOBODY) -> GatewayStatus:
    return status(Mode.REMOTE, lease_holder="Anna", lease_epoch=3, succession=named)


def driven_by_anna(who: str, lease_epoch: int, named: Succession = NOBODY) -> ViewModel:
    """The window of one of the two, while Anna drives."""
    said, cockpit = driven(named), operator(operator=who, lease_epoch=lease_epoch)
    return view_model(sights(said, operator=heard(cockpit), state=heard(state(guard="braking"))))


def test_only_the_window_of_whoever_drives_says_you_drive() -> None:
    """A second tower looks on: the same mode, and it would believe to drive."""
    assert driven_by_anna("Anna", 3).banner.look.words == "YOU DRIVE" and driven_by_anna("Anna", 3).toast
    for who, lease_epoch in (("Ben", 0), ("Ben", 8), ("Anna", 0)):
        model = driven_by_anna(who, lease_epoch)
        assert (model.banner.look.words, model.banner.look.driver) == ("ANNA DRIVES", Driver.OTHER_OPERATOR)
        assert (model.banner.hint, model.toast) == ("You look on", "")


def test_a_window_whose_cockpit_does_not_answer_goes_by_its_own_operators_name() -> None:
    for name, words in (("Anna", "YOU DRIVE"), ("Ben", "ANNA DRIVES"), ("", "YOU DRIVE")):
        assert view_model(sights(driven(), operator=None, operator_name=name)).banner.look.words == words


def test_enter_does_not_pass_the_car_on_while_it_would_pass_what_the_guard_holds_it_for() -> None:
    cockpit, held = operator(operator="Anna", lease_epoch=3), state(guard="holding", speed_m_s=0.5)
    model = view_model(sights(driven(NAMED), operator=heard(cockpit), state=heard(held)))
    assert model.card is not None and model.card.action == "Not now: something is close"


def test_what_another_operator_drove_is_nobodys_take_over_here() -> None:
    log = DriveLog()
    for mode, at_s in ((Mode.AUTONOMOUS, 1), (Mode.TAKEOVER_REQUESTED, 5), (Mode.REMOTE, 9), (Mode.STOPPED, 20)):
        stamp = at_s * 1_000_000_000
        log.add_status(replace(driven(), mode=mode, mode_since_ns=stamp, stamp_ns=stamp), another=mode is Mode.REMOTE)
    assert (log.takeover_s, log.seconds_in(Mode.REMOTE)) == ((), 0.0)
    assert [stretch.another for stretch in log.stretches()] == [False, False, True, False]


def test_why_the_car_gives_no_pictures_stands_where_they_would_be() -> None:
    said = view_model(sights(driven(), pictures={}, video_note="offer refused: two windows watch this car already")).picture
    assert (said.title, said.detail) == ("NO PICTURE", "Offer refused: two windows watch this car already")


def test_the_next_operator_is_led_to_the_take_over_and_the_driver_to_passing_the_car_on() -> None:
    his, hers = driven_by_anna("Ben", 8, NAMED), driven_by_anna("Anna", 3, NAMED)
    assert his.card is not None and hers.card is not None and driven_by_anna("Cleo", 0, NAMED).card is None
    assert (his.card.title, hers.card.title) == ("TAKE OVER FROM ANNA", "BEN TAKES OVER")
    assert hers.card.action == "Press Enter to pass the car on" and hers.card.remaining_text == "30.0 s left"
    assert (his.card.remaining_share, his.operator.lease) == (0.5, "Next after Anna")
    assert his.briefing is not None and hers.briefing is None


def test_what_is_missing_for_a_change_of_operators_stands_in_both_windows() -> None:
    ready = {"dead_man": True, "armed": True, "wheel_phase": "ready", "operator": "Ben", "lease_epoch": 8}
    for named, his, hers, note in (
        (NAMED, "Not yet: Anna has not passed the car on", "Press Enter to pass the car on", ""),
        (replace(AGREED, refused="align the wheel"), "Not yet: align", "Drive on until Ben", "Ben: align"),
        (AGREED, "Press Enter to take over", "Drive on until Ben has it", ""),
        (replace(NAMED, lease_epoch=0), "Not yet", "Drive on: Ben's cockpit has not asked yet", ""),
    ):
        said = driven(named)
        card = view_model(sights(said, operator=heard(operator(**ready)))).card
        other = driven_by_anna("Anna", 3, named).card
        assert card is not None and card.action.startswith(his)
        assert other is not None and other.action.startswith(hers) and other.note.startswith(note)
