"""Health of every loop and process: lateness, counts, what was dropped."""

from wire.messages.base import Count, Message, Milliseconds, Name, Seconds, Text, TimeNs


class LoopHealth(Message):
    """1 Hz per loop: how late its cycles were in the last second, against their own deadline."""

    stamp_ns: TimeNs
    process: Name  # wire.topics.PROGRAMS
    loop: Name
    period_ms: Milliseconds
    cycles: Count  # since start
    late_cycles: Count  # since start, later than one period
    lateness_p50_ms: Milliseconds  # of the last second
    lateness_max_ms: Milliseconds
    scheduling: Text  # "fifo 10", "other" and why
    dropped: dict[Name, Count]  # messages this process dropped, by reason
    process_cpu_s: Seconds = 0.0  # CPU the whole process has used since it started
    instance: Name = ""  # random per start: two towers' cockpits have one name; "" where there can be only one
    machine_stolen_s: Seconds | None = None  # CPU taken away from the machine since it booted; told by the hubs alone
