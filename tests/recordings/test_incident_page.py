"""A dossier of a small drive whose every figure is known: autonomous, remote at 8 s, a safe stop at 14 s, stopped at 16 s.

Each picture shows its number, tens on the left and ones on the right as levels of grey: which one is on the page can be read off.
"""

import base64
import re
from collections.abc import Callable
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import av
import cv2
import msgspec
import numpy as np
import pytest
from msgspec.structs import replace
from typer.testing import CliRunner

from recordings.program import app
from wire.audit_chain import Chain, follow
from wire.authority import issue, new_authority
from wire.configuration import read_sections, shipped
from wire.messages.audit import AuditEntry, AuditKind
from wire.messages.automation import Scene, TrackedObject
from wire.messages.base import encode
from wire.messages.session import Action, HandOverReply, HandOverRequest, Outcome
from wire.messages.vehicle import Actuation, GatewayCycle, Mode, VehicleDescription
from wire.picture import EncodedPicture, pack_picture
from wire.topics import Role

S, MS = 10**9, 10**6
BEGIN = 100 * S  # vehicle clock
END = BEGIN + 20 * S
SHOWN_AFTER = 120 * MS  # capture to screen
PICTURE = 200 * MS  # between two
MODES = ((0, Mode.AUTONOMOUS), (8, Mode.REMOTE), (14, Mode.SAFE_STOP), (16, Mode.STOPPED))
NOW_NS = round(datetime.now(UTC).timestamp()) * S
AUTHORITY = new_authority()
HUB = issue(Role.VEHICLE_HUB, (), AUTHORITY)
CAR = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
ASKED = Actuation(road_wheel_angle_rad=0.2, acceleration_m_s2=2.0)
SENT = Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=0.5)


def mode_at(now_ns: int) -> tuple[Mode, int]:
    """The mode and since when."""
    return max(((mode, BEGIN + at * S) for at, mode in MODES if BEGIN + at * S <= now_ns), key=lambda item: item[1])


def cycle(now_ns: int) -> GatewayCycle:
    """From 10 to 11 s the gate changes steering and acceleration; at 7.5 s the operator asks and is granted; 14 s: no command."""
    at_s = (now_ns - BEGIN) / S
    inputs: dict[str, Any] = {"feedback": None, "anything": 1}
    outputs: dict[str, Any] = {"send": True, "requested": ASKED, "applied": ASKED, "rules": (), "causes": ()}
    if 10 <= at_s < 11:
        outputs |= {"applied": SENT, "rules": ("speed cap",)}
    if 14 <= at_s < 15:
        outputs |= {"causes": ("command_lost",)}
    if at_s == 7.5:
        question = HandOverRequest(lease_epoch=1, number=4, action=Action.TAKE, sent_ns=0)
        inputs |= {"hand_over_requests": (question,)}
        outputs |= {
            "hand_over_replies": (HandOverReply(number=4, outcome=Outcome.REFUSED, rule="align <the> wheel", lease_epoch=1),)
        }
    return GatewayCycle(
        number=1,
        now_ns=now_ns,
        inputs=msgspec.Raw(msgspec.json.encode(inputs)),
        outputs=msgspec.Raw(msgspec.json.encode(outputs)),
        can_sent_ns=now_ns,
        command_sequence=1,
        new_command=True,
        loop_age_ms=0.0,
        mode=mode_at(now_ns)[0],
        rules=(),
    )


def scene(now_ns: int) -> Scene:
    person = TrackedObject(
        number=7,
        kind="person",
        x_m=20.0,
        y_m=2.0,
        velocity_x_m_s=0.0,
        velocity_y_m_s=-1.0,
        radius_m=0.3,
        deviation_m=0.1,
        static=False,
        age_s=3.0,
    )
    return Scene(
        stamp_ns=now_ns,
        x_m=(now_ns - BEGIN) / S,
        y_m=0.0,
        heading_rad=0.0,
        speed_m_s=1.0,
        yaw_rate_rad_s=0.0,
        deviation_m=0.05,
        station_m=0.0,
        offset_m=0.0,
        objects=(person,),
        plan=((0.0, 0.0), (60.0, 0.0)),
        stopping_corridor=((0.0, 0.0), (30.0, 0.0)),
    )


def pictures() -> list[EncodedPicture]:
    encoder: Any = av.CodecContext.create("libx264", "w")
    encoder.width, encoder.height, encoder.pix_fmt = 160, 96, "yuv420p"
    encoder.options = {"preset": "ultrafast", "tune": "zerolatency", "g": "10", "qp": "10"}
    made = []
    for number in range(100):
        image = np.full((96, 160, 3), 20 * (number // 10) + 30, np.uint8)
        image[:, 80:] = 20 * (number % 10) + 30
        for packet in encoder.encode(av.VideoFrame.from_ndarray(image, format="bgr24")):
            capture_ns = BEGIN + number * PICTURE
            unit = EncodedPicture(
                camera="front", capture_ns=capture_ns, sequence=number, is_idr=number % 10 == 0, annex_b=bytes(packet)
            )
            made.append(unit)
    return made


def audit_records() -> list[tuple[bytes, int]]:
    stands, made = Chain(), []
    for kind, at_s in ((AuditKind.DRIVE_BEGIN, 8), (AuditKind.DRIVE_END, 14), (AuditKind.HEAD, 14)):
        entry = AuditEntry(
            number=1,
            previous="0" * 64,
            kind=kind,
            stamp_ns=BEGIN + at_s * S,
            utc_ns=NOW_NS + at_s * S,
            boot_id="boot",
            vehicle_id="car-1",
            mode=mode_at(BEGIN + at_s * S)[0],
            drive=3,
            remote=kind is AuditKind.DRIVE_BEGIN,
            operator="anna",
            text="no valid command from the tower" if kind is AuditKind.DRIVE_END else "",
            signer_pem=HUB.certificate_pem.decode() if kind is AuditKind.HEAD else "",
        )
        stands, record = follow(stands, entry, HUB.key)
        made.append((encode(record), entry.stamp_ns))
    return made


@pytest.fixture(scope="module")
def drive(build: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    rows: list[tuple[str, Any, int]] = [("vehicle_description", CAR, BEGIN), ("vehicle_description", CAR, BEGIN + 13 * S)]
    rows += [("audit", record, at_ns) for record, at_ns in audit_records()]
    rows += [("video", pack_picture(picture), picture.capture_ns + 40 * MS) for picture in pictures()]
    for now_ns in range(BEGIN, END, 20 * MS):
        mode, since_ns = mode_at(now_ns)
        shown_ns = (now_ns - SHOWN_AFTER - BEGIN) // PICTURE * PICTURE + BEGIN if now_ns - SHOWN_AFTER >= BEGIN else 0
        command = replace(build.command(1, now_ns), displayed_capture_ns={"front": shown_ns} if shown_ns else {})
        rows += [("gateway_cycle", cycle(now_ns), now_ns), ("vehicle_state", build.state(now_ns, 2.5), now_ns)]
        rows.append(("gateway_status", replace(build.status(now_ns, mode, since_ns), cause=f"came to {mode}"), now_ns))
        if now_ns < BEGIN + 14 * S - 500 * MS:  # and then silence
            rows.append(("drive_command", command, now_ns))
        if now_ns % (100 * MS) == 0:
            rows += [("scene", scene(now_ns), now_ns), ("operator_status", build.operator(now_ns, 0, MS), now_ns)]
    return Path(build.recording(tmp_path_factory.mktemp("incident") / "drive.mcap", sorted(rows, key=lambda row: row[2])))


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["incident", *(str(argument) for argument in arguments)])


@pytest.fixture(scope="module")
def page(drive: Path) -> str:
    authority = drive.with_name("authority.pem")
    authority.write_bytes(AUTHORITY.certificate_pem)
    result = run(drive, "--at", "14", "--before", "7", "--after", "4", "--authority", authority)
    assert result.exit_code == 0, result.output
    assert result.stdout.strip() == str(drive.with_name("incident-14s.html"))
    return drive.with_name("incident-14s.html").read_text(encoding="utf-8")


class Balance(HTMLParser):
    """Every tag that is opened is closed, in order; every address the page names."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.names: set[str] = set()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.add(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "br", "img"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_is_well_formed_and_needs_nothing_else(page: str):
    parsed = Balance()
    parsed.feed(page)
    assert parsed.open == []
    assert "script" not in parsed.names and "link" not in parsed.names
    assert parsed.addresses and all(address.startswith("data:image/jpeg;base64,") for address in parsed.addresses)
    assert "http" not in page and "@import" not in page and "url(" not in page


def test_it_says_what_held_at_t(page: str):
    for words in (
        "The car was in SAFE STOP (the gateway brakes), because of: came to safe_stop.",
        "It went 9.0 km/h (2.50 m/s), the cap was 29.9 km/h, gear drive.",
        "anna used keyboard",
        "picture had been taken 800 ms before T; the command that says so arrived 520 ms before T.",
        "<dt>remote drive</dt><dd>3</dd>",
        "114.000 s, boot boot",
        "3 records, chain whole, signed up to record 3, 0 behind it",
    ):
        assert words in page


def test_it_tells_what_happened_in_the_order_of_time_with_what_was_asked_for_and_received(page: str):
    rows = re.findall(r'<td class="t">([^<]*) s</td><td><span class="tag (\w+)">\w+</span></td><td>(.*?)</td>', page)
    told = [(float(at), kind, words) for at, kind, words in rows]
    assert [(at, kind) for at, kind, _ in told] == [
        (-6.5, "asked"),
        (-6.0, "mode"),
        (-4.0, "rule"),
        (0.0, "cause"),
        (0.0, "mode"),
        (2.0, "mode"),
    ]
    by_kind = {kind: words for _, kind, words in told}
    assert "refused: align &lt;the&gt; wheel" in by_kind["asked"]
    assert (
        "for 0.98 s (50 cycles); at most +11.46° asked for, +5.73° applied, +2.00 m/s² asked for, +0.50 m/s² applied"
        in by_kind["rule"]
    )
    assert "command lost" in by_kind["cause"]
    assert [words.split(":")[0] for _, kind, words in told if kind == "mode"][1] == "REMOTE became SAFE STOP"


def test_each_picture_is_the_one_that_the_newest_command_had_on_screen(page: str):
    """At 14 s the last command is from 13.48 s: its picture, taken at or before 13.36 s, is number 66, taken at 13.2 s."""
    figures = re.findall(r'<img alt="" src="data:image/jpeg;base64,([^"]*)"><figcaption>(.*?)</figcaption>', page)
    assert len(figures) == 8
    for data, said in figures:
        image = cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)
        tens, ones = (round((float(half.mean()) - 30) / 20) for half in np.split(image, 2, axis=1))
        taken_s = float(re.findall(r"taken ([+-][\d.]+) s", said)[0])
        assert abs(14.0 + taken_s - (10 * tens + ones) * 0.2) < 0.006
    (at_t,) = [said for _, said in figures if said.startswith("T:")]
    assert "800 ms old" in at_t and "taken -0.80 s" in at_t


def test_an_old_picture_is_marked_and_a_fresh_one_is_not(page: str):
    figures = re.findall(r'<figure class="([^"]*)"><img[^>]*><figcaption>[^<]*<b>(\d+) ms old', page)
    assert {("old" in looks.split()) for looks, age in figures if int(age) > 200} == {True}
    assert all(int(age) >= 200 for looks, age in figures if "old" in looks.split())


def test_what_the_car_knew_is_drawn_with_its_objects_and_where_it_was(page: str):
    assert page.count('class="top-view"') == 4
    assert "<b>T</b>: map x 14.0 y 0.0 m, heading E, 3.6 km/h; 1 objects" in page
    assert "person 7, deviation 0.10 m, known for 3.0 s" in page


def test_the_audit_records_of_the_window_are_listed(page: str):
    table = page.split("<h2>Audit records</h2>")[1]
    assert re.findall(r'<td class="t">([^<]*) s</td><td>(\d)</td><td>([^<]*)</td>', table) == [
        ("-6.00", "1", "drive begin"),
        ("+0.00", "2", "drive end"),
        ("+0.00", "3", "head"),
    ]


def test_the_number_of_an_audit_record_and_a_time_of_day_name_the_same_moment(drive: Path, build: Any, tmp_path: Path):
    seconds = (build.utc_ns + BEGIN + 14 * S) // S % 86400
    clock = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"
    for said in ("#2", clock):
        output = tmp_path / f"{said[-1]}.html"
        assert run(drive, "--at", said, "--output", output).exit_code == 0
        assert "114.000 s, boot boot" in output.read_text(encoding="utf-8")


def test_a_recording_that_holds_little_gives_a_page_that_says_so(recorded: Callable[..., Path], build: Any, tmp_path: Path):
    path = recorded(build.imu_rows(300))
    result = run(path, "--at", "1", "--output", tmp_path / "page.html")
    assert result.exit_code == 0
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    for words in ("Nothing was recorded then.", "no rule acted", "No scene was recorded then.", "not verified"):
        assert words in page


def test_what_can_be_fixed_is_one_line_and_exit_code_2(drive: Path, tmp_path: Path):
    for arguments, words in (
        ((drive, "--at", "21"), "the recording is from"),
        ((drive, "--at", "#9"), "it has 1 to 3"),
        ((tmp_path / "none.mcap", "--at", "1"), "name a recording"),
        ((drive, "--at", "1", "--output", tmp_path / "no" / "page.html"), "--output FILE"),
    ):
        result = run(*arguments)
        assert (result.exit_code, result.stdout) == (2, "")
        assert words in result.stderr and len(result.stderr.splitlines()) == 1
