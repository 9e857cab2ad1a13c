"""What the window says, and that it can say it whatever arrives: models first, then pixels."""

from typing import Any

import msgspec
import numpy as np
import pygame
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.messages import autonomy_status, gateway_status, operator_status
from tower.window.age_history import Sample
from tower.window.drive_log import DriveLog
from tower.window.fonts import clean, fit, width, wrap
from tower.window.forecast import Forecast
from tower.window.hud import Hud, next_turn
from tower.window.keys import WindowKeys
from tower.window.looks import LOOKS, NO_LINK, WAITING, Driver
from tower.window.picture_age import PictureSeen, PictureState
from tower.window.picture_layout import Box
from tower.window.sights import Sights
from tower.window.view_model import view_model
from tower.window.views import Tone
from wire.configuration import read_sections, shipped
from wire.latest import Received
from wire.messages.automation import AutonomyStatus, PlannerView, Reason, RoadMap, Scene, TakeoverRequest
from wire.messages.base import Gear, Lights, Wipers
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import Actuation, GatewayStatus, Mode, MotionToMotion, VehicleDescription, VehicleState

NOW = 50_000_000_000_000
MS = 1_000_000
WORDS = {  # the brief's table, written out again
    Mode.STANDBY: "STANDBY",
    Mode.AUTONOMOUS: "CAR DRIVES",
    Mode.TAKEOVER_REQUESTED: "CAR DRIVES",
    Mode.HANDING_OVER: "HANDING OVER",
    Mode.REMOTE: "YOU DRIVE",
    Mode.HANDING_BACK: "YOU DRIVE",
    Mode.LOCAL_DRIVER: "LOCAL DRIVER",
    Mode.SAFE_STOP: "STOPPING",
    Mode.STOPPED: "STOPPED",
    Mode.EMERGENCY_STOP: "EMERGENCY STOP",
}
REQUEST = TakeoverRequest(
    number=1,
    raised_ns=1,
    budget_s=15.0,
    place=(1.0, 2.0),
    reasons=(Reason(channel="planner", text="no path keeps clear"), Reason(channel="map", text="barrier not in the map")),
)


def status(mode: Mode, **changes: Any) -> GatewayStatus:
    plain = gateway_status(stamp_ns=1, mode=mode, mode_since_ns=1, cause="because", lease_holder="Anna", lease_epoch=3)
    return msgspec.structs.replace(plain, **changes)


MOTION = MotionToMotion(
    total_ms=250.0,
    bound_ms=92.0,
    picture_ms=120.0,
    camera_ms=0.0,
    scan_out_ms=0.0,
    steering_ms=130.0,
    acceleration_ms=110.0,
    steering_measured=True,
    acceleration_measured=True,
)


def state(**changes: Any) -> VehicleState:
    none = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    plain = VehicleState(
        stamp_ns=1,
        boot_id="b",
        sequence=1,
        speed_m_s=5.0,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=none.gear,
        requested=none,
        applied=none,
        rules=(),
        speed_cap_m_s=4.0,
        loop_age_ms=120.0,
        command_age_ms=3.0,
    )
    return msgspec.structs.replace(plain, **changes)


def operator(**changes: Any) -> OperatorStatus:
    plain = operator_status(
        dead_man=True,
        wheel_phase="ready",
        gear=state().gear,
        indicators=state().applied.indicators,
        clock_bound_ns=MS,
        round_trip_ms=40.0,
    )
    return msgspec.structs.replace(plain, **changes)


def at_goal() -> AutonomyStatus:
    return autonomy_status(stamp_ns=1, sequence=1, clear_s=0.0, drivable_s=0.0, goal_reached=True)


def heard(message: Any, ago_ms: float = 10.0) -> Received[Any]:
    return Received(message, NOW - round(ago_ms * MS))


def sights(said: GatewayStatus | None, ago_ms: float = 10.0, **changes: Any) -> Sights:
    known: dict[str, Any] = {
        "now_ns": NOW,
        "status": heard(said, ago_ms) if said is not None else None,
        "state": heard(state()),
        "operator": heard(operator()),
        "pictures": {"front": PictureSeen(NOW - 80 * MS, NOW - 20 * MS)},
        "log": DriveLog(),
    }
    return Sights(**(known | changes))


@pytest.mark.parametrize("mode", list(Mode))
def test_every_mode_has_its_words_from_the_cars_own_status(mode: Mode) -> None:
    assert view_model(sights(status(mode))).banner.look.words == WORDS[mode]


@pytest.mark.parametrize(
    ("car", "cockpit", "words", "tone"),
    [
        ({}, {}, "Lease of the car held", Tone.GOOD),
        ({"certificate_left_s": 3601.0}, {}, "Lease of the car held", Tone.GOOD),
        ({"certificate_left_s": 1500.0}, {}, "Lease of the car held, certificates end in 25 min", Tone.WARN),
        ({"lease_holder": "Bob"}, {}, "Lease of the car held by Bob", Tone.WARN),
        ({"lease_holder": "", "lease_note": "Carla took it"}, {"lease_epoch": 0}, "No lease of the car: Carla took it", Tone.WARN),
        (
            {"lease_holder": ""},
            {"lease_epoch": 0, "lease_note": "you hold car-2"},
            "No lease of the car: you hold car-2",
            Tone.WARN,
        ),
    ],
)
def test_the_operator_reads_whether_he_holds_the_lease_for_how_long_and_who_took_it(car: Any, cockpit: Any, words: str, tone: Tone):
    shown = view_model(sights(status(Mode.STANDBY, **car), operator=heard(operator(**cockpit)))).operator
    assert (shown.lease, shown.lease_tone) == (words, tone)


@given(st.sampled_from(Mode), st.floats(500.1, 1e7))
def test_a_stale_status_says_that_there_is_no_link_and_never_who_drives(mode: Mode, ago_ms: float) -> None:
    model = view_model(sights(status(mode, request=REQUEST, guard_remaining_s=5.0), ago_ms))
    assert model.banner.look.words == "NO LINK TO THE CAR"
    assert model.banner.look.driver is Driver.UNKNOWN
    assert model.card is None
    assert model.dial.cap_km_h is None


def test_before_the_first_status_the_window_waits() -> None:
    assert view_model(sights(None)).banner.look == WAITING


def test_the_car_that_is_waited_for_or_held_is_named() -> None:
    """There may be several to choose from."""
    assert view_model(sights(None, vehicle_id="car-7")).banner.cause == "Nothing heard of car-7 yet"
    known = {"description": read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]}
    held = view_model(sights(status(Mode.STANDBY, lease_holder="Anna", lease_epoch=3), **known)).operator
    assert held.lease == "Lease of simulated-1 held"
    other = view_model(sights(status(Mode.STANDBY, lease_holder="Bob", lease_epoch=4), **known)).operator
    assert other.lease == "Lease of simulated-1 held by Bob"


def test_a_car_that_stands_says_why_without_saying_twice_that_it_stands() -> None:
    assert view_model(sights(status(Mode.STOPPED, cause="stands: the picture froze"))).banner.cause == "The picture froze"


def test_no_two_looks_share_words_and_pattern_or_colour_and_pattern() -> None:
    looks = [*LOOKS.values(), WAITING, NO_LINK]
    assert len({(look.words, look.pattern) for look in looks}) == len(looks)
    assert len({(look.colour, look.pattern) for look in looks}) == len(looks)


def test_words_stand_out_from_their_colour() -> None:
    """WCAG 2.1 contrast of large text: at least 3 to 1."""

    def luminance(colour: tuple[int, int, int]) -> float:
        parts = [c / 255 / 12.92 if c / 255 <= 0.04045 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in colour]
        return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]

    for look in (*LOOKS.values(), WAITING, NO_LINK):
        bright, dark = sorted((luminance(look.colour), luminance(look.ink)), reverse=True)
        assert (bright + 0.05) / (dark + 0.05) >= 3.0, look.words


TAKE_STORY = (
    (operator(lease_epoch=0, lease_note="held by Ben"), "", "Wait for the lease: held by Ben"),
    (operator(armed=False), "", "Release both pedals once"),
    (operator(dead_man=False), "hold the dead-man control", "Hold Shift"),
    (operator(wheel_phase="align", alignment_error_rad=0.5), "align the wheel", "Turn the wheel right to the car's angle"),
    (operator(wheel_phase="align", alignment_error_rad=-0.5), "align the wheel", "Turn the wheel left to the car's angle"),
    (operator(), "no new picture on your screen", "Not yet: no new picture on your screen"),
    (operator(), "", "Press Enter to take over"),
    (operator(device="scripted"), "", "Scripted operator: press Enter to take over"),
)


@pytest.mark.parametrize(("said", "refused", "action"), TAKE_STORY)
def test_a_request_says_what_to_do_now(said: OperatorStatus, refused: str, action: str) -> None:
    asking = status(Mode.TAKEOVER_REQUESTED, request=REQUEST, budget_remaining_s=7.5, take_refused=refused)
    card = view_model(sights(asking, operator=heard(said))).card
    assert card is not None
    assert card.action == action
    assert card.remaining_text == "7.5 s to standstill"
    assert card.remaining_share == 0.5
    assert card.reasons == (("planner", "No path keeps clear"), ("map", "Barrier not in the map"))


@pytest.mark.parametrize("mode", list(Mode))
def test_a_stop_that_is_not_confirmed_stands_before_everything_else(mode: Mode) -> None:
    said = status(mode, request=REQUEST, guard_remaining_s=3.0)
    card = view_model(sights(said, operator=heard(operator(stop_state="unconfirmed")))).card
    assert card is not None
    assert (card.title, card.tone) == ("STOP NOT CONFIRMED", Tone.BAD)


def test_the_guard_after_a_hand_back_counts_down_and_then_leaves() -> None:
    card = view_model(sights(status(Mode.AUTONOMOUS, guard_remaining_s=4.0))).card
    assert card is not None
    assert (card.remaining_text, card.remaining_share) == ("4.0 s guard", 0.4)
    assert view_model(sights(status(Mode.AUTONOMOUS))).card is None


def test_requested_and_applied_stand_side_by_side_with_the_rule_between_them() -> None:
    car = state(
        requested=Actuation(road_wheel_angle_rad=0.3, acceleration_m_s2=2.0),
        applied=Actuation(road_wheel_angle_rad=0.15, acceleration_m_s2=-4.0),
        rules=("speed cap", "jerk"),
    )
    controls = view_model(sights(status(Mode.REMOTE), state=heard(car))).controls
    assert (controls.steer_requested, controls.steer_applied) == (0.5, 0.25)  # of 0.6 rad
    assert (controls.drive_requested, controls.drive_applied) == (1.0, -0.5)  # of 2 and of 8 m/s2
    assert (controls.rule_text, controls.limited) == ("Limited by speed cap, jerk", True)
    assert controls.steer_text == "8.6° L"


def test_the_collision_guard_speaks_to_whoever_drives_and_to_nobody_else() -> None:
    def toast(mode: Mode, guard: str) -> str:
        return view_model(sights(status(mode), state=heard(state(guard=guard)))).toast

    assert toast(Mode.REMOTE, "holding") == "Collision guard: something is close. Enter: pass it at walking pace"
    assert toast(Mode.REMOTE, "blind").startswith("Collision guard blind")
    assert toast(Mode.REMOTE, "clear") == toast(Mode.AUTONOMOUS, "blind") == ""


def test_an_override_is_not_called_a_limit() -> None:
    car = state(rules=("guard overridden",), guard="overridden")
    assert view_model(sights(status(Mode.REMOTE), state=heard(car))).controls.rule_text == "Applied as requested"


def test_old_figures_are_not_shown() -> None:
    model = view_model(sights(status(Mode.REMOTE), state=heard(state(), 400.0), operator=heard(operator(), 1500.0)))
    assert not model.dial.fresh
    assert not model.controls.fresh
    assert model.operator.lease == "It does not answer"


def test_a_frozen_picture_says_so_with_its_age() -> None:
    model = view_model(sights(status(Mode.REMOTE), pictures={"front": PictureSeen(NOW - 1400 * MS, NOW - 1300 * MS)}))
    assert model.picture.state is PictureState.FROZEN
    assert (model.picture.title, model.picture.detail) == ("FROZEN", "The picture is 1.4 s old")


@pytest.mark.parametrize("mode", list(Mode))
def test_a_briefing_is_given_before_a_take_over_and_never_to_one_who_drives(mode: Mode) -> None:
    promised = Forecast(expected_ms=110, worst_ms=250, seconds=60, first_m_s=3.33, cap_m_s=6.67)
    reaching = view_model(sights(status(mode, request=REQUEST), forecast=promised)).briefing
    idle = view_model(sights(status(mode, request=REQUEST), forecast=promised, operator=heard(operator(dead_man=False)))).briefing
    assert (idle is not None) is (mode is Mode.TAKEOVER_REQUESTED)
    assert (reaching is not None) is (mode in (Mode.TAKEOVER_REQUESTED, Mode.STANDBY, Mode.AUTONOMOUS, Mode.STOPPED))
    if reaching is not None:
        assert [(figure.text, figure.tone) for figure in reaching.figures] == [
            ("D", Tone.GOOD),
            ("110 ms, at worst 250", Tone.WARN),
            ("12, then 24 km/h", Tone.WARN),
        ]


def test_a_briefing_names_a_gear_that_would_change_and_a_link_that_would_stop_the_car() -> None:
    promised = Forecast(expected_ms=400, worst_ms=900, seconds=60, first_m_s=0.9, cap_m_s=1.9)
    asking = status(Mode.TAKEOVER_REQUESTED, request=REQUEST)
    said = view_model(sights(asking, forecast=promised, operator=heard(operator(gear=Gear.REVERSE)))).briefing
    assert said is not None
    assert (said.figures[0].text, said.figures[0].tone) == ("D, yours R", Tone.WARN)
    assert said.figures[1].tone is Tone.BAD
    unknown = view_model(sights(asking)).briefing
    assert unknown is not None and unknown.figures[1].text == "not known yet"


@pytest.mark.parametrize("mode", list(Mode))
def test_a_lost_focus_is_said_when_the_window_reads_the_device(mode: Mode) -> None:
    """On the card while the operator's controls count, as a toast otherwise; a wheel needs no focus."""
    steered = mode in (Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK)
    for device in ("keyboard", "gamepad"):
        model = view_model(sights(status(mode), focus=False, window_device=device, operator=heard(operator(device=device))))
        assert ("no focus" in model.toast) is not steered
        assert (model.card is not None and model.card.title == "CONTROLS RELEASED") is steered
    scripted = view_model(sights(status(mode), focus=False, operator=heard(operator(device="scripted"))))
    assert scripted.toast == ""
    assert scripted.card is None or scripted.card.title != "CONTROLS RELEASED"
    assert "Scripted operator drives the controls" in scripted.operator.note


@pytest.mark.parametrize("mode", [Mode.REMOTE, Mode.SAFE_STOP, Mode.STOPPED])
def test_controls_that_were_lost_are_named_as_the_cause(mode: Mode) -> None:
    lost = heard(operator(device="Logitech G920", device_note="Logitech G920 unplugged", dead_man=False, armed=False))
    model = view_model(sights(status(mode), operator=lost))
    assert model.banner.cause == "Logitech G920 unplugged"
    assert model.operator.note == "Logitech G920 unplugged"
    assert "the left paddle" in model.operator.dead_man_text


def test_what_is_to_be_done_with_the_pedals_is_said_as_long_as_they_are_not_armed() -> None:
    hint = "Press and release both pedals once"
    unarmed = heard(operator(armed=False, device_hint=hint))
    model = view_model(sights(status(Mode.TAKEOVER_REQUESTED, request=REQUEST), operator=unarmed))
    assert model.operator.note == hint
    assert model.card is not None and model.card.action == hint


@pytest.mark.parametrize(
    ("lights", "wipers", "text"),
    [
        (Lights.OFF, Wipers.OFF, ""),
        (Lights.LOW, Wipers.OFF, "low beam"),
        (Lights.HIGH, Wipers.FAST, "HIGH BEAM · wipers fast"),
    ],
)
def test_the_dial_shows_the_lights_and_wipers_that_the_car_says_are_on(lights: Lights, wipers: Wipers, text: str) -> None:
    assert view_model(sights(status(Mode.REMOTE), state=heard(state(lights=lights, wipers=wipers)))).dial.lamps == text


def test_the_end_is_shown_at_the_goal_once_the_car_stands() -> None:
    def end(speed_m_s: float, mode: Mode, autonomy: Received[AutonomyStatus] | None) -> bool:
        return view_model(sights(status(mode), state=heard(state(speed_m_s=speed_m_s)), autonomy=autonomy)).end is not None

    assert end(0.0, Mode.AUTONOMOUS, heard(at_goal()))
    assert not end(2.0, Mode.AUTONOMOUS, heard(at_goal()))
    assert not end(0.0, Mode.STOPPED, None)
    assert end(0.0, Mode.EMERGENCY_STOP, None)


class Grey:
    """A picture of one grey level, whatever part and size is asked for."""

    capture_ns, decoded_ns, shape = 1, 2, (1280, 720)

    def __init__(self, level: int) -> None:
        self._level = level

    def pixels(self, part: Box | None, size: tuple[int, int]) -> np.ndarray:
        return np.full((size[1], size[0], 4), self._level, np.uint8)


def drawn(seen: Sights, size: tuple[int, int] = (1280, 720), grey: int = 200) -> np.ndarray:
    surface = pygame.Surface(size)
    Hud().draw(surface, {name: Grey(grey) for name in ("front", "left", "rear")}, view_model(seen))
    return pygame.surfarray.array3d(surface).swapaxes(0, 1)  # (H, W, 3) RGB


def share_of(pixels: np.ndarray, colour: tuple[int, int, int]) -> float:
    return float((np.abs(pixels.astype(int) - colour).max(axis=-1) <= 3).mean())


@pytest.mark.parametrize("mode", list(Mode))
def test_the_frame_and_the_tab_carry_the_colour_of_the_mode(mode: Mode) -> None:
    pixels = drawn(sights(status(mode)), grey=255)
    look = LOOKS[mode]
    strips = (pixels[:12], pixels[-12:], pixels[12:-12, :12], pixels[12:-12, -12:])
    assert all(share_of(strip, look.colour) > 0.2 for strip in strips)
    assert share_of(pixels[8:44, 560:720], look.colour) > 0.3
    assert share_of(pixels[300:600, 400:880], (255, 255, 255)) == 1.0  # the road ahead is all picture


def test_a_frozen_picture_is_darkened_and_taped_over() -> None:
    pixels = drawn(sights(status(Mode.REMOTE), pictures={"front": PictureSeen(NOW - 1400 * MS, NOW - 1300 * MS)}), grey=255)
    assert int(pixels[500:600, 500:800].max()) < 110
    assert share_of(pixels[288:438, 12:-12], (245, 179, 1)) > 0.08


@given(st.text(max_size=400), st.integers(4, 40), st.integers(0, 600))
@settings(max_examples=60, deadline=None)
def test_fitted_text_fits_and_only_what_can_be_printed_is_drawn(text: str, size_px: int, room_px: int) -> None:
    assert clean(text).isprintable()
    assert width(fit(text, size_px, 400, room_px), size_px, 400) <= room_px
    assert len(wrap(text, size_px, 400, room_px, 3)) <= 3


_STRATEGIES: dict[type[Any], st.SearchStrategy[Any]] = {}


def message(type_: type[Any]) -> st.SearchStrategy[Any]:
    """Any valid message, its numbers often at the ends of their ranges."""
    if type_ not in _STRATEGIES:
        fields = msgspec.inspect.type_info(type_)
        assert isinstance(fields, msgspec.inspect.StructType)
        _STRATEGIES[type_] = st.builds(type_, **{field.name: value(field.type) for field in fields.fields})
    return _STRATEGIES[type_]


def value(kind: Any) -> st.SearchStrategy[Any]:
    inspect = msgspec.inspect
    match kind:
        case inspect.FloatType():
            bound, highest = kind.ge if kind.ge is not None else kind.gt, kind.le
            assert bound is not None and highest is not None  # every number of ours has a range
            lowest = float(bound) if kind.gt is None else float(bound) + 1e-3
            return st.sampled_from([float(highest), lowest]) | st.floats(lowest, float(highest))
        case inspect.IntType():
            low = kind.ge if kind.ge is not None else -(2**62)
            high = kind.le if kind.le is not None else 2**62
            return st.sampled_from([low, high]) | st.integers(low, high)
        case inspect.StrType() if kind.pattern is not None:
            return st.from_regex(kind.pattern, fullmatch=True)
        case inspect.StrType():
            return st.text(max_size=12) | st.just("W " * ((kind.max_length or 20) // 2))
        case inspect.BoolType():
            return st.booleans()
        case inspect.NoneType():
            return st.none()
        case inspect.EnumType() | inspect.StructType() as named:
            return st.sampled_from(named.cls) if isinstance(named, inspect.EnumType) else message(named.cls)
        case inspect.UnionType():
            return st.one_of([value(each) for each in kind.types])
        case inspect.TupleType():
            return st.tuples(*[value(each) for each in kind.item_types])
        case inspect.VarTupleType():
            return st.lists(value(kind.item_type), min_size=kind.min_length or 0, max_size=(kind.min_length or 0) + 3).map(tuple)
        case inspect.DictType():
            return st.dictionaries(value(kind.key_type), value(kind.value_type), max_size=2)
    raise TypeError(f"no strategy for {kind}")


MAYBE = {
    name: st.none() | message(type_).map(heard)
    for name, type_ in (
        ("state", VehicleState),
        ("operator", OperatorStatus),
        ("autonomy", AutonomyStatus),
        ("scene", Scene),
        ("planner", PlannerView),
    )
}


@given(
    seen=st.fixed_dictionaries(
        {
            **MAYBE,
            "status": message(GatewayStatus).map(heard),
            "road_map": st.none() | message(RoadMap),
            "description": st.none() | message(VehicleDescription),
            "focus": st.booleans(),
            "recording": st.text(max_size=80),
            "keys": st.builds(WindowKeys, help_open=st.booleans(), quit_asked_ns=st.none() | st.just(NOW)),
            "pictures": st.dictionaries(
                st.sampled_from(("front", "left", "rear")),
                st.builds(PictureSeen, st.integers(0, 2**62), st.integers(0, NOW)),
            ),
            "rear_wanted": st.booleans(),
        }
    ),
    size=st.sampled_from([(1280, 720), (320, 180), (500, 900)]),
)
@settings(max_examples=80, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
def test_whatever_valid_messages_arrive_the_window_is_drawn(seen: dict[str, Any], size: tuple[int, int]) -> None:
    pixels = drawn(sights(None, **seen), size)
    assert pixels.shape == (size[1], size[0], 3)
    assert float(pixels[::7, ::7].std()) > 10.0  # something stands there


def test_changed_panels_are_drawn_again_in_turn_one_per_picture() -> None:
    names, turn, drawn_again = ["a", "b", "c"], "", []
    for _ in range(6):
        turn = next_turn(turn, names, ["a", "c"])
        drawn_again.append(turn)
    assert drawn_again == ["a", "c"] * 3
    assert next_turn("b", names, []) == "b"


@pytest.mark.parametrize(
    ("told", "words"),
    [
        (None, "–"),  # a gateway of before
        (MOTION, "260 ±90 ms"),  # the loop of 130 that stands beside it, and what the car adds to its own 120
    ],
)
def test_motion_to_motion_stands_beside_the_loop_age(told: MotionToMotion | None, words: str) -> None:
    history = (Sample(NOW - 200 * MS, 90, 130), Sample(NOW, 90, 150))
    assert view_model(sights(status(Mode.REMOTE), state=heard(state(motion_to_motion=told)), history=history)).link.motion == words


def test_while_the_operator_does_not_drive_no_motion_is_told() -> None:
    history = (Sample(NOW - 200 * MS, 90, None), Sample(NOW, 90, None))
    assert (
        view_model(sights(status(Mode.AUTONOMOUS), state=heard(state(motion_to_motion=MOTION)), history=history)).link.motion == "–"
    )
