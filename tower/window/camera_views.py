"""Which cameras the window shows now, and what stands over each. Pure."""

from tower.window.picture_age import FROZEN_AFTER_NS, SIDE_FROZEN_AFTER_NS, PictureState, age_ns, picture_state
from tower.window.picture_layout import ASSUMED, FRONT, LEFT, RIGHT, SHOWN, Shape
from tower.window.sights import Sights
from tower.window.views import CameraView
from tower.window.words import seconds
from wire.messages.vehicle import VehicleDescription
from wire.rear_view import REAR


def cameras_of(description: VehicleDescription | None) -> tuple[str, ...]:
    """The cameras of that car that have a place in the window; () while the car is unknown."""
    return () if description is None else tuple(camera.name for camera in description.cameras if camera.name in SHOWN)


def camera_views(sights: Sights) -> dict[str, CameraView]:
    """The front camera always, the sides when the car has them, the rear one only while it is wanted."""
    shapes: dict[str, Shape] = dict(ASSUMED)
    if sights.description is not None:
        shapes |= {camera.name: (camera.width_px, camera.height_px) for camera in sights.description.cameras}
    shown = [name for name in SHOWN if name in shapes and (name != REAR or sights.rear_wanted)]
    return {name: _view(name, shapes[name], sights) for name in shown}


def _view(name: str, shape: Shape, sights: Sights) -> CameraView:
    seen = sights.pictures.get(name)
    limit_ns = SIDE_FROZEN_AFTER_NS if name in (LEFT, RIGHT) else FROZEN_AFTER_NS
    state = picture_state(seen, sights.now_ns, sights.clock_offset_ns, limit_ns)
    old = seconds((age_ns(seen, sights.now_ns, sights.clock_offset_ns) or 0) / 1e9)
    tag = {PictureState.NONE: "NO PICTURE", PictureState.FROZEN: f"FROZEN {old}", PictureState.LATE: f"LATE {old}"}
    return CameraView(shape=shape, state=state, tag="" if name == FRONT else tag.get(state, ""))
