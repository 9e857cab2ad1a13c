"""Sights -> ViewModel: what the window shows, without drawing it. Pure.

Who drives is taken from the car's gateway_status alone, and only while it is fresh.
"""

from math import ceil, degrees

from tower.window.briefing import briefing
from tower.window.camera_views import camera_views
from tower.window.card import UNFOCUSED, card, focus_is_missed
from tower.window.checks import CheckState
from tower.window.looks import Driver, known_mode, look_at
from tower.window.picture_age import PictureState, age_ns, picture_state
from tower.window.road_model import road_view
from tower.window.sights import Sights
from tower.window.views import (
    BannerView,
    CardView,
    ChecklistView,
    ControlsView,
    DialView,
    EndView,
    Figure,
    LinkView,
    MapView,
    OperatorView,
    PictureView,
    Tone,
    ViewModel,
)
from tower.window.words import (
    SCRIPTED_NOTE,
    dead_man_name,
    guard_words,
    lamps_text,
    milliseconds,
    minutes,
    rule_words,
    seconds,
    sentence,
)
from wire.messages.base import Gear, Indicators
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import Actuation, GatewayStatus, Mode, VehicleDescription, VehicleState

KM_H = 3.6  # km/h per m/s
STANDING_M_S = 0.3
_BEFORE_DRIVING = (None, Mode.STANDBY, Mode.AUTONOMOUS, Mode.SAFE_STOP, Mode.STOPPED)
_BLINK_NS = 350_000_000  # ours: half a period, 86 flashes a minute (UN R6: 60 to 120)
_CERTIFICATE_WARN_S = 3600.0  # ours: an hour, four times what the car refuses a take-over at
_SCALE_KM_H = 40  # of the dial before the car has said how fast it may go
_AGE_WARN_MS, _AGE_BAD_MS = 200, 500  # architecture: the speed cap falls above 200 ms, the car stops above 500 ms
_TRIP_WARN_MS, _TRIP_BAD_MS = 100, 250  # ours; comma calls 250 ms poor (reference/remote-driving.md)


def view_model(sights: Sights) -> ViewModel:
    """What every part of the window shows now."""
    the_card, picture = card(sights), _picture(sights)
    return ViewModel(
        picture=picture,
        cameras=camera_views(sights),
        road=road_view(sights),
        banner=_banner(sights, the_card is not None),
        dial=_dial(sights),
        controls=_controls(sights),
        link=_link(sights),
        operator=_operator(sights),
        map=_map(sights),
        card=the_card,
        briefing=briefing(sights),
        checklist=_checklist(sights),
        end=_end(sights),
        help_open=sights.keys.help_open,
        toast=_toast(sights, picture, the_card),
    )


def _picture(sights: Sights) -> PictureView:
    state = picture_state(sights.picture, sights.now_ns, sights.clock_offset_ns)
    age = age_ns(sights.picture, sights.now_ns, sights.clock_offset_ns)
    old = seconds((age or 0) / 1e9)
    title, detail = {
        PictureState.NONE: ("NO PICTURE", sentence(sights.video_note) or "Waiting for the camera"),
        PictureState.LIVE: ("", ""),
        PictureState.LATE: ("", ""),
        PictureState.FROZEN: ("FROZEN", f"The picture is {old} old"),
    }[state]
    return PictureView(state=state, title=title, detail=detail)


def _banner(sights: Sights, has_card: bool) -> BannerView:
    look = look_at(sights.status, sights.fresh_operator, sights.operator_name, sights.now_ns)
    status = sights.status.message if sights.status is not None else None
    mode = known_mode(sights.status, sights.now_ns)
    if mode is None or status is None:
        if sights.status is None:
            yet = f"Nothing heard of {sights.vehicle_id} yet" if sights.vehicle_id else ""
            return BannerView(look=look, cause=yet, hint="", tone=Tone.CALM)
        silent_s = (sights.now_ns - sights.status.received_ns) / 1e9
        return BannerView(look=look, cause=f"Nothing from the car for {seconds(silent_s)}", hint="", tone=Tone.BAD)
    if has_card:
        return BannerView(look=look, cause="", hint="", tone=Tone.CALM)
    stopping = look.driver is Driver.STOPPING or mode is Mode.STOPPED
    said = status.cause.removeprefix("stands: ") if mode is Mode.STOPPED else status.cause  # the tab says so
    cause = sentence(status.failsafe if mode is Mode.REMOTE and status.failsafe else said)
    hint = _hint(status, sights.fresh_operator, sights.another_drives)
    lost = sights.fresh_operator.device_note if sights.fresh_operator is not None else ""
    if lost and (stopping or mode is Mode.REMOTE):
        return BannerView(look=look, cause=sentence(lost), hint=hint, tone=Tone.BAD)
    return BannerView(
        look=look,
        cause="" if mode is Mode.REMOTE and not status.failsafe else cause,
        hint=hint,
        tone=Tone.BAD if stopping or status.failsafe else Tone.CALM,
    )


def _hint(status: GatewayStatus, operator: OperatorStatus | None, looks_on: bool) -> str:
    if looks_on:
        return "You look on"
    held = dead_man_name(operator.device if operator is not None else "keyboard")
    take = (
        "Any driving key takes the controls"
        if operator is not None and operator.device == "scripted"
        else f"Hold {held}, Enter: you drive"
    )
    back = "B hands back to the car" if status.hand_back_ready else sentence(status.hand_back_note)
    stopped = sentence(status.take_refused) or take
    return {
        Mode.STANDBY: f"E: the car drives · {take}",
        Mode.AUTONOMOUS: take,
        Mode.REMOTE: back,
        Mode.STOPPED: stopped,
        Mode.EMERGENCY_STOP: "Only at the car can it be released",
    }.get(status.mode, "")


def _dial(sights: Sights) -> DialView:
    state = sights.fresh_state
    most = sights.description.speed_max_remote_m_s * KM_H if sights.description is not None else _SCALE_KM_H * 0.75
    scale = int(min(max(ceil(most * 1.3 / 10) * 10, 20), 300))
    if state is None:
        return DialView(
            fresh=False, speed_km_h=0.0, cap_km_h=None, scale_km_h=scale, gear=Gear.PARK, lamps="", left_lit=False, right_lit=False
        )
    mode = known_mode(sights.status, sights.now_ns)
    capped = mode in (Mode.REMOTE, Mode.HANDING_OVER, Mode.HANDING_BACK)
    on = sights.now_ns // _BLINK_NS % 2 == 0
    applied = state.applied
    return DialView(
        fresh=True,
        speed_km_h=round(state.speed_m_s * KM_H * 4) / 4,
        scale_km_h=scale,
        gear=state.gear,
        cap_km_h=round(state.speed_cap_m_s * KM_H * 2) / 2 if capped else None,
        lamps=lamps_text(state),
        left_lit=on and (applied.hazard or applied.indicators is Indicators.LEFT),
        right_lit=on and (applied.hazard or applied.indicators is Indicators.RIGHT),
    )


def _controls(sights: Sights) -> ControlsView:
    state = sights.fresh_state
    if state is None:
        return ControlsView(
            fresh=False,
            steer_requested=0.0,
            steer_applied=0.0,
            steer_text="–",
            drive_requested=0.0,
            drive_applied=0.0,
            drive_text="–",
            rule_text="No state from the car",
            limited=False,
        )
    car = sights.description
    return ControlsView(
        fresh=True,
        steer_requested=_steer_share(state.requested, car),
        steer_applied=_steer_share(state.applied, car),
        steer_text=_side(degrees(state.applied.road_wheel_angle_rad)),
        drive_requested=_drive_share(state.requested, car),
        drive_applied=_drive_share(state.applied, car),
        drive_text=f"{_no_minus_zero(state.applied.acceleration_m_s2):+.1f} m/s²",
        rule_text=_rule_text(state),
        limited=bool(state.rules),
    )


def _rule_text(state: VehicleState) -> str:
    limiting = tuple(rule for rule in state.rules if rule != "guard overridden")  # that one allows
    if limiting:
        return f"Limited by {rule_words(limiting)}"
    asked, sent = state.requested, state.applied
    is_same = (asked.road_wheel_angle_rad, asked.acceleration_m_s2) == (sent.road_wheel_angle_rad, sent.acceleration_m_s2)
    return "Applied as requested" if is_same else "Not as requested"


def _no_minus_zero(value: float) -> float:
    return round(value, 1) or 0.0


def _side(angle_deg: float) -> str:
    rounded = round(abs(angle_deg), 1)
    return "0.0°" if not rounded else f"{rounded:.1f}° {'L' if angle_deg > 0 else 'R'}"


def _steer_share(actuation: Actuation, car: VehicleDescription | None) -> float:
    full = car.road_wheel_angle_max_rad if car is not None else 0.6  # typical of a passenger car, until ours has said
    return _share(actuation.road_wheel_angle_rad / full)


def _drive_share(actuation: Actuation, car: VehicleDescription | None) -> float:
    wanted = actuation.acceleration_m_s2
    forward, braking = (car.acceleration_max_m_s2, car.braking_max_m_s2) if car is not None else (2.0, 8.0)
    return _share(wanted / (forward if wanted > 0 else braking))


def _share(value: float) -> float:
    """In [-1, 1] and in steps of 1/200, finer than a pixel of the bar."""
    return round(min(max(value, -1.0), 1.0) * 200) / 200


def _tone(value: float | None, warn: float, bad: float) -> Tone:
    if value is None:
        return Tone.CALM
    return Tone.BAD if value > bad else Tone.WARN if value > warn else Tone.GOOD


def _link(sights: Sights) -> LinkView:
    operator, state = sights.fresh_operator, sights.fresh_state
    age = age_ns(sights.picture, sights.now_ns, sights.clock_offset_ns)
    complete = sights.history[:-1]  # the last sample still grows; figures that change five times a second can be read
    newest = complete[-1] if complete else None
    picture_ms = newest.picture_ms if newest is not None and age is not None and age < 1e9 else None if age is None else age / 1e6
    loop_ms = newest.loop_ms if newest is not None and state is not None else None
    trip_ms = operator.round_trip_ms if operator is not None and operator.clock_bound_ns > 0 else None
    figures = (
        Figure(label="picture", text=milliseconds(picture_ms), tone=_tone(picture_ms, _AGE_WARN_MS, _AGE_BAD_MS)),
        Figure(label="loop", text=milliseconds(loop_ms), tone=_tone(loop_ms, _AGE_WARN_MS, _AGE_BAD_MS)),
        Figure(label="trip", text=milliseconds(trip_ms), tone=_tone(trip_ms, _TRIP_WARN_MS, _TRIP_BAD_MS)),
    )
    bars, word = _quality(figures, known_mode(sights.status, sights.now_ns) is not None)
    return LinkView(
        bars=bars,
        word=word,
        figures=figures,
        samples=complete,
        now_ns=newest.at_ns if newest is not None else 0,
        motion=_motion(loop_ms, state) if loop_ms is not None and state is not None else "–",
    )


def _motion(loop_ms: float, state: VehicleState) -> str:
    """Of the loop age that stands beside it, in steps of ten: no figure that flickers."""
    said = state.motion_to_motion
    if said is None:
        return "–"
    total_ms = max(loop_ms + said.total_ms - state.loop_age_ms, 0.0)
    return f"{round(total_ms, -1):.0f} ±{round(said.bound_ms, -1):.0f} ms"


def _quality(figures: tuple[Figure, ...], linked: bool) -> tuple[int, str]:
    tones = [figure.tone for figure in figures]
    if not linked:
        return 0, "No link"
    if Tone.BAD in tones:
        return 1, "Link poor"
    if Tone.WARN in tones:
        return 2, "Link fair"
    return (4, "Link good") if tones.count(Tone.GOOD) == len(tones) else (3, "Connected")


def _operator(sights: Sights) -> OperatorView:
    operator = sights.fresh_operator
    if operator is None:
        return OperatorView(
            name="Cockpit", lease="It does not answer", lease_tone=Tone.BAD, dead_man=False, dead_man_text="", note=""
        )
    known = sights.status is not None and known_mode(sights.status, sights.now_ns) is not None
    lease, tone = ("Lease unknown", Tone.WARN)
    if sights.status is not None and known:
        car = sights.description.vehicle_id if sights.description is not None else "the car"
        lease, tone = _lease(sights.status.message, operator, car)
    held = dead_man_name(operator.device)
    note = SCRIPTED_NOTE if operator.device == "scripted" else operator.device_note or operator.device_hint
    return OperatorView(
        name=f"{operator.operator} · {operator.device}",
        lease=lease,
        lease_tone=tone,
        dead_man=operator.dead_man,
        note=note,
        dead_man_text="Dead-man held"
        if operator.dead_man
        else "Dead-man released"
        if operator.device == "scripted"
        else f"Released: hold {held}",
    )


def _lease(status: GatewayStatus, operator: OperatorStatus, car: str) -> tuple[str, Tone]:
    """With the car's id: there may be several to drive."""
    if status.succession.operator == operator.operator and operator.lease_epoch:
        return f"Next after {status.lease_holder}", Tone.GOOD
    if 0 < operator.lease_epoch == status.lease_epoch and status.lease_holder == operator.operator:
        left_s = status.certificate_left_s
        if left_s is not None and left_s < _CERTIFICATE_WARN_S:
            return f"Lease of {car} held, certificates end in {left_s / 60:.0f} min", Tone.WARN
        return f"Lease of {car} held", Tone.GOOD
    if status.lease_holder and status.lease_holder != operator.operator:
        return f"Lease of {car} held by {status.lease_holder}", Tone.WARN
    return f"No lease of {car}: {operator.lease_note or status.lease_note or 'asking it'}", Tone.WARN


def _map(sights: Sights) -> MapView:
    request = sights.status.message.request if sights.status is not None else None
    car = sights.description
    return MapView(
        road_map=sights.road_map,
        scene=sights.fresh_scene,
        trouble=request.place if request is not None else None,
        car_length_m=car.length_m if car is not None else 4.5,
        car_width_m=car.width_m if car is not None else 1.8,
    )


def _checklist(sights: Sights) -> ChecklistView | None:
    """Before the first drive, as long as something is open; a request and whoever reaches for the car come first."""
    mode = known_mode(sights.status, sights.now_ns)
    open_items = any(check.state is not CheckState.PASSED for check in sights.checks)
    driven = sights.log.seconds_in(Mode.REMOTE) > 0
    return ChecklistView(items=sights.checks) if open_items and not driven and mode in _BEFORE_DRIVING else None


def _toast(sights: Sights, picture: PictureView, shown: CardView | None) -> str:
    if sights.keys.quit_asked_ns is not None:
        return "Quit? Press Esc again"
    if picture.state is PictureState.LATE:
        age = age_ns(sights.picture, sights.now_ns, sights.clock_offset_ns) or 0
        return f"Picture late: it shows what was {seconds(age / 1e9)} ago"
    if focus_is_missed(sights) and (shown is None or shown.title != UNFOCUSED):
        return "The window has no focus: every control is released. Click here"
    return guard_words(sights.fresh_state.guard) if sights.fresh_state is not None and _is_remote(sights) else ""


def _is_remote(sights: Sights) -> bool:
    """It is this operator who drives."""
    return known_mode(sights.status, sights.now_ns) is Mode.REMOTE and not sights.another_drives


def _end(sights: Sights) -> EndView | None:
    """The drive is over: the goal is reached or the car is latched, and it stands."""
    mode, state = known_mode(sights.status, sights.now_ns), sights.fresh_state
    at_goal = sights.autonomy is not None and sights.autonomy.message.goal_reached
    if state is None or abs(state.speed_m_s) > STANDING_M_S or not (at_goal or mode is Mode.EMERGENCY_STOP):
        return None
    log = sights.log
    p50, p95 = log.loop_age_ms(0.5), log.loop_age_ms(0.95)
    loop = "–" if p50 is None else f"{milliseconds(p50)} / {milliseconds(p95)}"
    rows = (
        ("Duration", minutes(log.duration_s), None),
        ("You drove", minutes(log.seconds_in(Mode.REMOTE, Mode.HANDING_BACK)), Mode.REMOTE),
        ("The car drove", minutes(log.seconds_in(Mode.AUTONOMOUS)), Mode.AUTONOMOUS),
        ("The car drove and asked", minutes(log.seconds_in(Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER)), Mode.TAKEOVER_REQUESTED),
        ("Take-over after", ", ".join(seconds(value) for value in log.takeover_s[:4]) or "–", None),
        ("Loop age p50 / p95 while you drove", loop, None),
        ("Stops", str(log.stops), Mode.SAFE_STOP if log.stops else None),
    )
    return EndView(
        title="Drive complete" if at_goal else "Emergency stop: the car stands",
        rows=rows,
        stretches=log.stretches(),
        recording=sights.recording,
    )
