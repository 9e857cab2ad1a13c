"""`tower devices [list|calibrate|learn]`: its commands alone. What they do, and Rich with it, is loaded when one of them runs.

The wheel's forces start through the same program, and until they have started the wheel has none.
"""

from typing import Annotated

import typer

application = typer.Typer(help="Steering wheels and gamepads: list, calibrate, teach buttons.", add_completion=False)
Device = Annotated[str, typer.Option("--device", help="A part of its name, its id, or its place.")]


@application.callback(invoke_without_command=True)
def main(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        list_devices()


@application.command("list")
def list_devices() -> None:
    """Every device that could be driven with, and what is known about it."""
    from tower.devices.dialogue import show

    show()


@application.command("calibrate")
def calibrate_device(
    device: Device = "", rotation: Annotated[float, typer.Option(help="Degrees from end to end, of a wheel.")] = 900.0
) -> None:
    """Learn where steering and pedals are and where they end. Asks for each; saved for this device."""
    from tower.devices.dialogue import interview

    interview(device, rotation, steering=True)


@application.command("learn")
def learn_buttons(device: Device = "") -> None:
    """Learn what each button does. Asks for each; saved for this device."""
    from tower.devices.dialogue import interview

    interview(device, 900.0, steering=False)
