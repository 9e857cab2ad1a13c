"""What the planner among people weighed in a drive, as a foxglove.SceneUpdate beside each `planner_view`, for a 3D panel. Pure.

The layers of `autonomy plan --record` that the message has: people with two deviations, guidance classes, trajectories, the
chosen one. Nothing reads it back: `planner_view` is what a replay plays.
"""

from math import cos, pi, sin

from wire.messages.automation import PlannedWay, PlannerView, PredictedPlace
from wire.planner_colours import BRAKING, CLASSES, UNGUIDED, Rgb
from wire.scene_draw import Places, draw_guidance, draw_person, draw_trajectory, new_entity, new_scene

TOPIC = "planner_scene"
_CORNERS = 24
_ROUND = tuple((cos(2.0 * pi * k / _CORNERS), sin(2.0 * pi * k / _CORNERS)) for k in range(_CORNERS))
_OTHERS = {-1: UNGUIDED, -2: BRAKING}  # PlannedWay.identity


def encode_scene(view: PlannerView, time_ns: int) -> bytes:
    """The message; time_ns is the Unix time it stands for."""
    update = new_scene(time_ns)
    people, guidance, trajectories = (new_entity(update, name, time_ns) for name in ("people", "guidance", "trajectories"))
    for person in view.people:
        means = [(at.x_m, at.y_m) for at in person.places]
        draw_person(people, str(person.number), person.radius_m, means, map(two_sigma, person.places[1:]))
    for way in view.ways:
        if way.guidance:
            draw_guidance(guidance, way.guidance, colour_of(way))
        if way.trajectory:
            draw_trajectory(trajectories, way.trajectory, colour_of(way), way.feasible, way.chosen)
    encoded: bytes = update.SerializeToString()
    return encoded


def two_sigma(at: PredictedPlace) -> Places:
    """Corners of the ellipse two deviations around the place."""
    along, across = cos(at.axis_rad), sin(at.axis_rad)
    ring = ((2.0 * at.long_m * c, 2.0 * at.wide_m * s) for c, s in _ROUND)
    return [(at.x_m + u * along - v * across, at.y_m + u * across + v * along) for u, v in ring]


def colour_of(way: PlannedWay) -> Rgb:
    return _OTHERS.get(way.identity) or CLASSES[way.colour % len(CLASSES)]
