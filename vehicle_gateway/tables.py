"""The tables of authority and failsafe as Markdown, and the diagram of the modes, drawn from what the code runs. Pure.

`rewritten` puts them between their markers; a test holds the pages to it. Decides nothing, reads no file.
"""

from vehicle_gateway.authority import IN_ORDER, RECEIVES, SHORT, TABLE, Authority, Event, driving_source
from vehicle_gateway.failsafe import RULES, FailsafeLimits
from wire.messages.vehicle import Mode

FROM_EVERYWHERE = 5  # an event with the same end in so many modes is a line below the diagram, not so many arrows
BACK = "@"
Arrow = tuple[Mode, str, Event]  # from, its end ("back" for where the hand-over began), by


def modes_table() -> str:
    rows = (_row(mode.value, _drivers(mode), RECEIVES[mode].value if mode in RECEIVES else "-") for mode in Mode)
    return "\n".join((_row("mode", "drives", "receives"), _row("---", "---", "---"), *rows))


def authority_table() -> str:
    short = {mode: name for name, mode in SHORT.items()}
    head = _row("event, strongest first", *(f"{short[mode]} {mode.value.replace('_', ' ')}" for mode in Mode))
    rows = (_row(event.value, *(TABLE[event][mode] for mode in Mode)) for event in IN_ORDER)
    legend = "`.` nothing changes, `@` back to where the hand-over began, `SS*` only if the automation drives meanwhile"
    return "\n".join((head, _row(*("---",) * (len(Mode) + 1)), *rows, "", legend))


def diagram() -> str:
    """A Mermaid state diagram; what holds in many modes at once is said in a line each below it."""
    common = _common()
    drawn: dict[tuple[str, str], list[str]] = {}
    for mode, end, event in _arrows():
        if (event, end) not in common:
            drawn.setdefault((mode.value, end), []).append(event.value)
    arrows = (f"    {begin} --> {end}: {', '.join(events)}" for (begin, end), events in drawn.items())
    start = f"    [*] --> {Mode.STANDBY.value}"
    everywhere = (f"- from {', '.join(modes)}: `{event.value}` leads to {end}" for (event, end), modes in common.items())
    return "\n".join(("```mermaid", "stateDiagram-v2", start, *arrows, "```", *everywhere))


def failsafe_table(limits: FailsafeLimits) -> str:
    values = {name: getattr(limits, name) for name in limits.__struct_fields__}
    head = _row("cause, worst first", "begins with", "response", "tells the authority", "clears with")
    rows = (
        _row(
            cause.value,
            rule.when.format(**values),
            rule.response.name,
            rule.event.value if rule.event is not None else "-",
            rule.clears.format(**values),
        )
        for cause, rule in RULES.items()
    )
    return "\n".join((head, _row(*("---",) * 5), *rows))


BLOCKS = {
    "ARCHITECTURE.md": {"modes": modes_table, "diagram": diagram, "authority": authority_table},
    "vehicle_gateway/README.md": {"failsafe": lambda: failsafe_table(FailsafeLimits())},
}


def rewritten(page: str, text: str) -> str:
    """The page with each of its tables as the code has it. Raises ValueError for a page without their markers."""
    for name, draw in BLOCKS[page].items():
        begin, end = f"<!-- drawn: {name} -->", "<!-- end -->"
        before, found, rest = text.partition(begin)
        _, closed, after = rest.partition(end)
        if not (found and closed):
            raise ValueError(f'{page} has no "{begin}" ... "{end}" to write the table between: put the two lines back')
        text = f"{before}{begin}\n{draw()}\n{end}{after}"
    return text


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _drivers(mode: Mode) -> str:
    """Every source that may drive in it: a hand-over leaves that as it was where it began."""
    begins = [origin for origin in Mode if TABLE[Event.TAKE_GRANTED][origin] != "."] if mode is Mode.HANDING_OVER else [mode]
    found = {driving_source(Authority(mode=mode, origin=origin)): None for origin in begins}
    return " or ".join(source.value for source in found)


def _arrows() -> list[Arrow]:
    return [
        (mode, "back" if cell == BACK else SHORT[cell.removesuffix("*")].value, event)
        for event in IN_ORDER
        for mode, cell in TABLE[event].items()
        if cell != "."
    ]


def _common() -> dict[tuple[Event, str], list[Mode]]:
    found: dict[tuple[Event, str], list[Mode]] = {}
    for mode, end, event in _arrows():
        found.setdefault((event, end), []).append(mode)
    return {key: modes for key, modes in found.items() if len(modes) >= FROM_EVERYWHERE}
