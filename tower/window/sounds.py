"""The five sounds of the window, made when it starts, and the table that says when. Nothing else makes a sound; the checklist
plays the alarm once before the drive.

A sound tells who drives now; the alarm repeats as long as the car asks. Played with pygame; without a sound device, silent.
"""

import os
import sys
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pygame

from tower.window.looks import LOOKS, Driver
from wire.messages.vehicle import Mode

RATE_HZ = 44100


class Sound(StrEnum):
    REQUEST = "request"  # repeats while the request is open
    OPERATOR_DRIVES = "operator drives"
    CAR_DRIVES = "car drives"
    STOPPING = "stopping"
    PERSON_DRIVES = "person drives"  # the one in the car, or another operator


class Trial(StrEnum):
    """Of the sound, before the drive."""

    WAITING = "waiting"
    PLAYING = "playing"
    PLAYED = "played"
    FILED = "filed"  # SDL's disk driver has taken it: heard by nobody, but whole
    SILENT = "silent"  # no device, no sound wanted, or no volume


_BY_DRIVER = {
    Driver.OPERATOR: Sound.OPERATOR_DRIVES,
    Driver.CAR: Sound.CAR_DRIVES,
    Driver.STOPPING: Sound.STOPPING,
    Driver.PERSON_IN_CAR: Sound.PERSON_DRIVES,
    Driver.OTHER_OPERATOR: Sound.PERSON_DRIVES,
}


@dataclass(frozen=True, slots=True)
class Note:
    begin_s: float
    length_s: float
    pitch_hz: float
    level: float = 1.0


# Rising fifth: yours. Falling fifth: the car's. High and insistent: wanted. Low and even: stopping. Thrice the same: someone there.
SCORES: dict[Sound, tuple[float, tuple[Note, ...]]] = {  # length with the pause before a repeat, s
    Sound.REQUEST: (1.3, (Note(0.0, 0.16, 988.0), Note(0.2, 0.16, 740.0), Note(0.4, 0.16, 988.0), Note(0.6, 0.22, 740.0))),
    Sound.OPERATOR_DRIVES: (0.7, (Note(0.0, 0.22, 392.0, 0.8), Note(0.18, 0.45, 587.0, 0.9))),
    Sound.CAR_DRIVES: (0.7, (Note(0.0, 0.22, 587.0, 0.7), Note(0.18, 0.45, 392.0, 0.7))),
    Sound.PERSON_DRIVES: (0.8, (Note(0.0, 0.14, 523.0, 0.8), Note(0.22, 0.14, 523.0, 0.8), Note(0.44, 0.2, 523.0, 0.8))),
    Sound.STOPPING: (1.2, (Note(0.0, 0.28, 196.0), Note(0.4, 0.28, 196.0), Note(0.8, 0.34, 147.0))),
}


def sound_at_change(before: Driver | None, now: Driver | None) -> Sound | None:
    """What to play when another one drives; None: nobody knows who does. Silent as long as the same one drives."""
    return None if now is None or now is before else _BY_DRIVER.get(now)


def alarm_on(mode: Mode | None) -> bool:
    return mode is Mode.TAKEOVER_REQUESTED


def end_of(volume: float, driver: str | None) -> Trial:
    """What becomes of a sound that was played to its end. driver: SDL's, None when it chooses by itself."""
    if volume == 0.0 or driver == "dummy":
        return Trial.SILENT
    return Trial.FILED if driver == "disk" else Trial.PLAYED


def waveform(sound: Sound) -> npt.NDArray[np.int16]:
    """(N, 2) samples: sine with two soft harmonics, raised-cosine ends so that nothing clicks."""
    length_s, notes = SCORES[sound]
    mix = np.zeros(round(length_s * RATE_HZ))
    for note in notes:
        tone = _tone(note)
        begin = round(note.begin_s * RATE_HZ)
        room = mix[begin : begin + len(tone)]
        room += tone[: len(room)]
    mono = np.clip(mix * 0.45, -1.0, 1.0) * 32767
    return np.repeat(mono.astype(np.int16)[:, None], 2, axis=1)


def _tone(note: Note) -> npt.NDArray[np.float64]:
    t = np.arange(round(note.length_s * RATE_HZ)) / RATE_HZ
    wave = sum(share * np.sin(2 * np.pi * note.pitch_hz * k * t) for k, share in ((1, 1.0), (2, 0.28), (3, 0.12)))
    edge = np.minimum(t / 0.012, (note.length_s - t) / 0.09)
    return np.asarray(note.level * wave * (0.5 - 0.5 * np.cos(np.pi * np.clip(edge, 0.0, 1.0))))


def has_sound_device() -> bool:
    """On Linux ALSA complains on stderr when there is none, so it is not asked then."""
    runtime = Path(os.environ.get("XDG_RUNTIME_DIR", "/nonexistent"))
    return (
        not sys.platform.startswith("linux")
        or "PULSE_SERVER" in os.environ
        or "SDL_AUDIODRIVER" in os.environ
        or any(path.exists() for path in (runtime / "pulse", runtime / "pipewire-0"))
        or any(Path("/dev/snd").glob("pcm*p"))
    )


class Player:
    """Plays; remembers who drove when it last heard of it, so that a gap in the link makes no sound when it ends."""

    def __init__(self, enabled: bool, volume: float) -> None:
        self._known: Driver | None = None
        self._sounds = _prepared(volume) if enabled else {}
        self._end = end_of(volume, os.environ.get("SDL_AUDIODRIVER")) if self._sounds else Trial.SILENT
        self._alarm: pygame.mixer.Channel | None = None
        self._tried: pygame.mixer.Channel | None = None

    def try_out(self) -> None:
        """Play the alarm once, so that the operator knows it and the checklist that it can be played."""
        if self._sounds and self._tried is None:
            self._tried = self._sounds[Sound.REQUEST].play()

    @property
    def trial(self) -> Trial:
        """PLAYED once the device has taken the whole of it; whether it was heard only the operator knows."""
        if self._end is Trial.SILENT:
            return self._end
        if self._tried is None:
            return Trial.WAITING
        return Trial.PLAYING if self._tried.get_busy() else self._end

    def hear(self, mode: Mode | None, another: bool = False) -> None:
        """Once per cycle, with the mode shown now. another: it is another operator who drives."""
        driver = None if mode is None else Driver.OTHER_OPERATOR if another else LOOKS[mode].driver
        sound = sound_at_change(self._known, driver)
        self._known = driver or self._known
        if sound is not None and sound in self._sounds and not alarm_on(mode):
            self._sounds[sound].play()
        self._switch_alarm(alarm_on(mode))

    def _switch_alarm(self, wanted: bool) -> None:
        if wanted and self._alarm is None and self._sounds:
            self._alarm = self._sounds[Sound.REQUEST].play(loops=-1)
        elif not wanted and self._alarm is not None:
            self._alarm.stop()
            self._alarm = None


def _prepared(volume: float) -> dict[Sound, pygame.mixer.Sound]:
    if not has_sound_device():
        os.environ["SDL_AUDIODRIVER"] = "dummy"
    try:
        pygame.mixer.init(RATE_HZ, -16, 2, 512)
    except pygame.error:
        return {}  # a window without sound is better than none; the alarm is on the screen as well
    sounds = {sound: pygame.mixer.Sound(buffer=waveform(sound).tobytes()) for sound in Sound}
    for made in sounds.values():
        made.set_volume(volume)
    return sounds
