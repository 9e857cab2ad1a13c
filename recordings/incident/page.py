"""The incident dossier as one HTML page that needs nothing else: no network, no script. Pure: puts together, computes nothing."""

from datetime import UTC, datetime
from html import escape

from recordings.audit.report import place, utc
from recordings.incident import axis, top_view
from recordings.incident.evidence import Evidence
from recordings.incident.film import FROZEN_S, Seen
from recordings.incident.spans import newest
from recordings.incident.story import Sentence, at_the_moment, story_of
from recordings.incident.style import CSS
from recordings.incident.tracks import tracks_of
from wire.messages.audit import AuditEntry
from wire.software import PACKAGE

VIEWS_S = (-2.0, -1.0, 0.0, 1.0)  # top views: T and around it
TIMES = "All times are seconds from T, on the car's own clock; what came from the tower stands where it arrived in the car."


def page_of(evidence: Evidence, film: dict[str, tuple[Seen, ...]], path: str, chain: str) -> str:
    """chain: what the check of the audit trail said, one sentence."""
    sections = (
        _head(evidence, path, chain),
        _section("At T", _at(evidence)),
        _section("What happened", _story(story_of(evidence))),
        _section("On one time axis", axis.draw(tracks_of(evidence), -evidence.before_s, evidence.after_s) + _note(TIMES)),
        _section("What the operator saw", "".join(_strip(camera, strip) for camera, strip in film.items()) + _note(SEEN)),
        _section("What the car knew", _views(evidence) + _note(KNEW)),
        _section("Audit records", _records(evidence, chain)),
    )
    title = f"Incident {_when(evidence)} - {evidence.vehicle_id}"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{CSS}</style></head>'
        f"<body><main>{''.join(sections)}</main></body></html>\n"
    )


SEEN = (
    "The picture that the newest command then in the car says was on the operator's screen, decoded from the recorded video; its "
    "age is the moment minus its capture stamp, both on the car's clock. Red: older than 200 ms, for the car no new picture."
)
KNEW = (
    "The car's own belief, its heading up; not what was there. Blue, dashed: its plan. Green: its stopping corridor. "
    "Objects with one standard deviation: cones orange, barriers brown, others by name; the line is the way within the next second."
)


def _when(evidence: Evidence) -> str:
    return datetime.fromtimestamp(evidence.at_utc_ns / 1e9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def _section(title: str, inside: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{inside}</section>"


def _note(words: str) -> str:
    return f'<p class="note">{escape(words)}</p>'


def _head(evidence: Evidence, path: str, chain: str) -> str:
    operator, status = newest(evidence.operators, 0.0), newest(evidence.statuses, 0.0)
    drive = next((each.entry.drive for _, each in reversed(evidence.audit) if each.entry.remote), 0)
    facts = (
        ("T, UTC", utc(evidence.at_utc_ns)),
        ("T, car's clock", f"{evidence.at_vehicle_ns / 1e9:.3f} s, boot {status.boot_id if status else '-'}"),
        ("T, recording", f"{(evidence.at_utc_ns - evidence.start_utc_ns) / 1e9:.3f} s after its first message"),
        ("shown", f"{evidence.before_s:.1f} s before to {evidence.after_s:.1f} s after T"),
        ("car", evidence.vehicle_id or "-"),
        ("operator", f"{operator.operator} ({operator.device})" if operator else "-"),
        ("remote drive", str(drive) if drive else "none in what is shown"),
        ("software", " ".join(evidence.versions.get(name, "") for name in (PACKAGE, "commit")).strip() or "-"),
        ("recording", path),
        ("audit trail", chain),
    )
    listed = "".join(f"<dt>{escape(name)}</dt><dd>{escape(said)}</dd>" for name, said in facts)
    lead = f'<p class="lead">{escape(_when(evidence))}, {escape(evidence.vehicle_id)}</p>'
    return f'<h1>Incident dossier</h1>{lead}<dl class="facts">{listed}</dl>'


def _at(evidence: Evidence) -> str:
    said = at_the_moment(evidence)
    return f'<div class="at">{"".join(f"<p>{escape(words)}</p>" for words in said) or "<p>Nothing was recorded then.</p>"}</div>'


def _story(sentences: tuple[Sentence, ...]) -> str:
    if not sentences:
        return "<p>Nobody asked for anything, nothing stepped in, and nothing changed hands.</p>"
    rows, passed = [], False
    for each in sentences:
        now = ' class="now"' if each.t_s > 0.0 and not passed else ""
        passed = passed or each.t_s > 0.0
        rows.append(
            f'<tr{now}><td class="t">{each.t_s:+.2f} s</td><td><span class="tag {each.kind}">{each.kind}</span></td>'
            f"<td>{escape(each.words)}</td></tr>"
        )
    return f"<table>{''.join(rows)}</table>" + _note("The red line is T.")


def _strip(camera: str, strip: tuple[Seen, ...]) -> str:
    return f'<h3>{escape(camera)}</h3><div class="strip">{"".join(map(_frame, strip))}</div>'


def _frame(seen: Seen) -> str:
    looks = " ".join(("now",) * (seen.t_s == 0.0) + ("old",) * (seen.capture_s is not None and seen.age_ms > FROZEN_S * 1e3))
    moment = "T" if seen.t_s == 0.0 else f"{seen.t_s:+.2f} s"
    if seen.capture_s is None:
        return f'<figure class="{looks}"><div class="none">nothing on screen</div><figcaption>{moment}</figcaption></figure>'
    picture = f'<img alt="" src="data:image/jpeg;base64,{seen.jpeg}">' if seen.jpeg else NOT_RECORDED
    shown = f", on screen {seen.shown_after_ms:.0f} ms after it was taken" if seen.shown_after_ms is not None else ""
    said = f"{moment}: <b>{seen.age_ms:.0f} ms old</b><br>taken {seen.capture_s:+.2f} s{shown} (by the {seen.said_by})"
    return f'<figure class="{looks}">{picture}<figcaption>{said}</figcaption></figure>'


NOT_RECORDED = '<div class="none">this picture is not in the recording, or not whole</div>'


def _views(evidence: Evidence) -> str:
    figures = []
    for t_s in VIEWS_S:
        scene, status = newest(evidence.scenes, t_s), newest(evidence.statuses, t_s)
        if scene is None or not -evidence.before_s <= t_s <= evidence.after_s:
            continue
        drawn = top_view.draw(scene, evidence.road, evidence.vehicle, status.request if status else None)
        moment = "T" if t_s == 0.0 else f"{t_s:+.1f} s"
        age_ms = (t_s - evidence.since_s(scene.stamp_ns)) * 1e3
        said = (
            f"<b>{moment}</b>: map x {scene.x_m:.1f} y {scene.y_m:.1f} m, heading {top_view.heading_words(scene)}, "
            f"{scene.speed_m_s * 3.6:.1f} km/h; {len(scene.objects)} objects, position ±{scene.deviation_m:.2f} m; "
            f"{age_ms:.0f} ms old"
        )
        figures.append(f'<figure class="{"now" if t_s == 0.0 else ""}">{drawn}<figcaption>{said}</figcaption></figure>')
    return f'<div class="views">{"".join(figures)}</div>' if figures else "<p>No scene was recorded then.</p>"


def _records(evidence: Evidence, chain: str) -> str:
    rows = [_record(t_s, each.entry) for t_s, each in evidence.audit if -evidence.before_s <= t_s <= evidence.after_s]
    columns = ("from T", "no.", "record", "of", "what", "mode", "drive", "operator", "position")
    head = "".join(f"<th>{name}</th>" for name in columns)
    table = f"<table><tr>{head}</tr>{''.join(rows)}</table>" if rows else "<p>No audit record falls into what is shown.</p>"
    return table + _note(f"Audit trail: {chain}")


def _record(t_s: float, entry: AuditEntry) -> str:
    lasted = f" ({entry.times} in {entry.lasted_s:.2f} s)" if entry.times else ""
    cells = (
        str(entry.number),
        entry.kind.replace("_", " "),
        entry.subject.replace("_", " "),
        f"{entry.text}{lasted}".strip(),
        entry.mode.replace("_", " "),
        f"{entry.drive}{' goes on' if entry.remote else ''}" if entry.drive else "-",
        entry.operator or "-",
        place(entry.position),
    )
    return f'<tr><td class="t">{t_s:+.2f} s</td>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}</tr>'
