"""Settings of the window: section [tower.window]. The thresholds stand beside the code that uses them."""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import DeviceDelay, Message, Name, Ratio, Text


class WindowSettings(Message):
    width_px: Annotated[int, Meta(ge=320, le=7680)] = 1280
    height_px: Annotated[int, Meta(ge=180, le=4320)] = 720
    full_screen: bool = False
    display: Annotated[int, Meta(ge=0, le=15)] = 0  # number of the monitor, as SDL counts them from 0
    span_displays: bool = False  # one window without a border over all monitors side by side: two, or three of one size
    scan_out_delay_ms: DeviceDelay = 0.0  # from the flip to light: compositor, scan-out, panel; 0 where nobody looks
    scan_out_bound_ms: DeviceDelay = 0.0  # the delay is within +- this; the car adds both to the loop age
    sound: bool = True
    volume: Ratio = 0.6
    checklist: bool = True  # before the drive; a scripted operator has none
    snapshot: Name = "window.png"  # written into the session's folder while the operator drives; "" writes none
    replay: Text = ""  # what recording is played: stands across the window all the time, and nothing can be driven; "" is live
