"""When the window makes a sound, and that the sounds are sounds."""

import itertools

import numpy as np
import pytest

from tower.window.looks import LOOKS, Driver
from tower.window.sounds import SCORES, Sound, Trial, alarm_on, end_of, sound_at_change, waveform
from wire.messages.vehicle import Mode

OPERATOR = {Mode.REMOTE, Mode.HANDING_BACK}
CAR = {Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER}
STOPPING = {Mode.SAFE_STOP, Mode.EMERGENCY_STOP}
PERSON = {Mode.LOCAL_DRIVER}
GROUPS = (
    (OPERATOR, Sound.OPERATOR_DRIVES),
    (CAR, Sound.CAR_DRIVES),
    (STOPPING, Sound.STOPPING),
    (PERSON, Sound.PERSON_DRIVES),
)


@pytest.mark.parametrize(
    ("volume", "driver", "end"),
    [
        (0.6, None, Trial.PLAYED),
        (0.6, "alsa", Trial.PLAYED),
        (0.6, "disk", Trial.FILED),
        (0.6, "dummy", Trial.SILENT),
        (0.0, None, Trial.SILENT),
        (0.0, "disk", Trial.SILENT),
    ],
)
def test_what_nobody_can_hear_is_not_called_played(volume: float, driver: str | None, end: Trial) -> None:
    assert end_of(volume, driver) is end


def test_a_sound_tells_of_every_change_of_the_driver_and_of_nothing_else() -> None:
    for before, now in itertools.product(Mode, Mode):
        expected = next((sound for modes, sound in GROUPS if now in modes and before not in modes), None)
        assert sound_at_change(LOOKS[before].driver, LOOKS[now].driver) == expected, (before, now)


def test_a_mode_nobody_knows_makes_no_sound() -> None:
    assert all(sound_at_change(driver, None) is None for driver in Driver)


def test_who_loses_the_car_to_another_operator_hears_it_and_so_does_he() -> None:
    assert sound_at_change(Driver.OPERATOR, Driver.OTHER_OPERATOR) is Sound.PERSON_DRIVES
    assert sound_at_change(Driver.OTHER_OPERATOR, Driver.OPERATOR) is Sound.OPERATOR_DRIVES


def test_the_alarm_is_on_while_the_car_asks_and_only_then() -> None:
    assert [mode for mode in (*Mode, None) if alarm_on(mode)] == [Mode.TAKEOVER_REQUESTED]


def test_the_sounds_are_loud_enough_unclipped_end_in_silence_and_differ() -> None:
    waves = {sound: waveform(sound) for sound in Sound}
    assert set(SCORES) == set(Sound)
    for wave in waves.values():
        assert wave.shape[1] == 2
        assert 6000 < int(np.abs(wave).max()) < 32767
        assert abs(int(wave[0, 0])) < 200
        assert abs(int(wave[-1, 0])) < 200
    for one, other in itertools.combinations(waves.values(), 2):
        assert one.shape != other.shape or not np.array_equal(one, other)


def test_no_two_sounds_have_the_same_notes_or_begin_at_the_same_pitch_and_go_the_same_way() -> None:
    """Told apart by ear: pitch of the first note, direction, number of notes."""

    def heard(sound: Sound) -> tuple[float, float, int]:
        notes = SCORES[sound][1]
        return notes[0].pitch_hz, float(np.sign(notes[-1].pitch_hz - notes[0].pitch_hz)), len(notes)

    assert len({heard(sound) for sound in Sound}) == len(Sound)
    for one, other in itertools.combinations(Sound, 2):
        first, second = heard(one), heard(other)
        semitones = abs(12 * np.log2(first[0] / second[0]))
        assert semitones >= 2.0 or first[1:] != second[1:], (one, other)


def test_your_tone_rises_and_the_cars_tone_falls() -> None:
    yours, cars = SCORES[Sound.OPERATOR_DRIVES][1], SCORES[Sound.CAR_DRIVES][1]
    assert yours[0].pitch_hz < yours[-1].pitch_hz
    assert cars[0].pitch_hz > cars[-1].pitch_hz
