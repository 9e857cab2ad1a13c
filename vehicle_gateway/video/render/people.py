"""People on foot: a skeleton that walks with the gait's phase, dressed and drawn limb by limb. True perspective.

Proportions after common anthropometric tables (50th percentile, stature 1.75 m); the gait is a plain pendulum with a bent
knee in the swing, the feet stay on the ground. Not modelled: faces, wind, standing at rest other than upright.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import cv2
import numpy as np

from vehicle_gateway.video.render.brush import SHIFT, Colour, darken, fixed, shaded
from vehicle_gateway.video.render.projection import NEAR_M, Corners, Flags, Floats, Picture, View
from vehicle_gateway.video.render.shadows import FULL_SHADE, shadow_offset_m
from wire.messages.sensing import MovingPerson

STATURE_M = 1.75
THIGH_M, SHANK_M, UPPER_ARM_M, FOREARM_M = 0.43, 0.42, 0.30, 0.27
HIP_HALF_M, SHOULDER_HALF_M = 0.09, 0.19
FULL_SWING_M_S = 1.2  # walking at this speed or faster swings the legs fully
DETAIL_PX = 42.0  # below this height a person gets no lights and no face
ARM_PARTS = 6  # the last limbs of the list
_ROUND = 6  # points of a limb's rounded end
_HALF_TURN = np.linspace(-pi / 2, pi / 2, _ROUND)


@dataclass(frozen=True, slots=True)
class Looks:
    scale: float  # of STATURE_M
    shirt: Colour  # BGR
    trousers: Colour
    shoes: Colour
    skin: Colour
    hair: Colour
    has_bag: bool


_SHIRTS = (
    (52.0, 52.0, 186.0),
    (150.0, 92.0, 40.0),
    (222.0, 222.0, 218.0),
    (60.0, 120.0, 70.0),
    (44.0, 166.0, 222.0),
    (60.0, 56.0, 54.0),
    (150.0, 110.0, 170.0),
    (168.0, 160.0, 70.0),
)
_TROUSERS = ((92.0, 66.0, 46.0), (48.0, 46.0, 46.0), (120.0, 140.0, 156.0), (76.0, 70.0, 66.0), (110.0, 84.0, 60.0))
_SKINS = ((150.0, 178.0, 222.0), (120.0, 152.0, 200.0), (80.0, 108.0, 156.0), (52.0, 72.0, 110.0))
_HAIRS = ((30.0, 34.0, 42.0), (44.0, 66.0, 96.0), (90.0, 150.0, 190.0), (120.0, 120.0, 122.0))


def dress(count: int, seed: int) -> list[Looks]:
    """Somebody different for every person of the scenario."""
    random = np.random.default_rng(seed + 3)
    shirts = random.permutation(len(_SHIRTS))

    def one_of(choices: tuple[Colour, ...]) -> Colour:
        return choices[int(random.integers(len(choices)))]

    return [
        Looks(
            random.uniform(0.93, 1.06),
            _SHIRTS[shirts[i % len(_SHIRTS)]],
            one_of(_TROUSERS),
            (40.0, 40.0, 44.0),
            one_of(_SKINS),
            one_of(_HAIRS),
            bool(random.random() < 0.4),
        )
        for i in range(count)
    ]


@dataclass(frozen=True, slots=True)
class Limb:
    start_m: tuple[float, float, float]  # person's frame: x ahead, y left, z up
    end_m: tuple[float, float, float]
    start_radius_m: float
    end_radius_m: float
    colour: Colour


def limbs(phase: float, speed_m_s: float, looks: Looks) -> list[Limb]:
    """Everything but torso and head, at stature STATURE_M. The lower foot stands on z = 0."""
    swing = min(1.0, max(0.0, speed_m_s) / FULL_SWING_M_S)
    legs = [_leg(2 * pi * (phase + half), swing, side * HIP_HALF_M) for half, side in ((0.0, 1.0), (0.5, -1.0))]
    rise = -min(joint[2] for leg in legs for joint in leg[2:]) + 0.03
    parts = []
    for leg in legs:
        hip, knee, ankle, toe = ((x, y, z + rise) for x, y, z in leg)
        parts += [
            Limb(hip, knee, 0.085, 0.062, looks.trousers),
            Limb(knee, ankle, 0.062, 0.045, looks.trousers),
            Limb((ankle[0] - 0.04, ankle[1], ankle[2] - 0.03), toe, 0.045, 0.035, looks.shoes),
        ]
    shoulder_z = 1.40 + rise
    for half, side in ((0.5, 1.0), (0.0, -1.0)):
        parts += _arm(2 * pi * (phase + half), swing, side * SHOULDER_HALF_M, shoulder_z, looks)
    return parts


_HIP_Z = 0.90


def _leg(angle: float, swing: float, y_m: float) -> list[tuple[float, float, float]]:
    """Hip, knee, ankle and toe, the hip at z = _HIP_Z."""
    thigh = 0.44 * swing * sin(angle)
    bend = 0.06 + swing * (0.10 + 0.75 * max(0.0, cos(angle)) ** 2)
    knee = (THIGH_M * sin(thigh), y_m, _HIP_Z - THIGH_M * cos(thigh))
    shank = thigh - bend
    ankle = (knee[0] + SHANK_M * sin(shank), y_m, knee[2] - SHANK_M * cos(shank))
    foot = shank * 0.6 + 0.1 * swing * sin(angle)
    return [(0.0, y_m, _HIP_Z), knee, ankle, (ankle[0] + 0.17 * cos(foot), y_m, ankle[2] - 0.05 + 0.17 * sin(foot))]


def _arm(angle: float, swing: float, y_m: float, z_m: float, looks: Looks) -> list[Limb]:
    upper = 0.42 * swing * sin(angle)
    fore = upper + 0.15 + 0.25 * swing
    out = 1.12 * y_m
    elbow = (UPPER_ARM_M * sin(upper), out, z_m - UPPER_ARM_M * cos(upper))
    hand = (elbow[0] + FOREARM_M * sin(fore), out, elbow[2] - FOREARM_M * cos(fore))
    tip = (hand[0] + 0.07 * sin(fore), out, hand[2] - 0.07 * cos(fore))
    return [
        Limb((0.0, y_m, z_m), elbow, 0.058, 0.048, looks.shirt),
        Limb(elbow, hand, 0.046, 0.036, looks.shirt),
        Limb(hand, tip, 0.036, 0.034, looks.skin),
    ]


Patch = tuple[Corners, Colour]  # a convex polygon


@dataclass(frozen=True, slots=True)
class Figure:
    """One person, ready to fill: polygons in drawing order, and before them shadows (corners in pixels, share of light)."""

    shadows: list[tuple[Floats, float]]
    patches: list[Patch]

    def draw(self, canvas: Picture) -> None:
        for ring, share in self.shadows:
            darken(canvas, ring, share)
        for corners, colour in self.patches:
            cv2.fillConvexPoly(canvas, corners, colour, cv2.LINE_AA, SHIFT)


def figures(view: View, people: Sequence[MovingPerson], looks: Sequence[Looks]) -> list[Figure]:
    """All people at once. Nothing of one who stands beside or behind the camera's plane; limbs that cross it are left out."""
    if not people:
        return []
    all_parts = [limbs(person.phase, person.speed_m_s, look) for person, look in zip(people, looks, strict=True)]
    places = np.array([[end for part in parts for end in (part.start_m, part.end_m)] + _trunk(parts) for parts in all_parts])
    scale = np.array([look.scale for look in looks])
    camera = view.to_camera(_in_map(places * scale[:, None, None], people))
    count = len(all_parts[0])
    ends = camera[:, : 2 * count].reshape(len(people), count, 2, 3)
    radii = np.array([[(part.start_radius_m, part.end_radius_m) for part in parts] for parts in all_parts]) * scale[:, None, None]
    outlines, visible = _capsules(view, ends, radii)
    trunks = _trunks(view, camera[:, 2 * count :], people, scale)
    shadows = _shadows(view, people, scale)
    foot_m = view.to_camera([(person.x_m, person.y_m, 0.0) for person in people])[:, 2].tolist()
    shapes = fixed(outlines), fixed(_lit(outlines))
    depth = ends[..., 2].mean(axis=2)
    order = np.argsort(-depth, axis=1).tolist()
    near_arm = depth <= camera[:, 2 * count, 2:]
    near_arm[:, : count - ARM_PARTS] = False  # legs end under the shirt
    result = []
    for k, look in enumerate(looks):
        if foot_m[k] < NEAR_M:
            result.append(Figure([], []))
            continue
        detailed = STATURE_M * view.focal_px / foot_m[k] > DETAIL_PX
        patches = _limb_patches((shapes[0][k], shapes[1][k]), visible[k].tolist(), all_parts[k], detailed)
        before = near_arm[k].tolist()
        behind = [patch for i in order[k] if not before[i] for patch in patches[i]]
        over = [patch for i in order[k] if before[i] for patch in patches[i]]
        result.append(Figure(shadows[k][: 2 if detailed else 1], behind + trunks.patches(k, look, detailed) + over))
    return result


def _trunk(parts: list[Limb]) -> list[tuple[float, float, float]]:
    """Middle of the chest, waist, hips, neck and head; and the bag on the back."""
    hip = parts[0].start_m[2]
    return [
        (0.0, 0.0, hip + 0.47),
        (0.0, 0.0, hip + 0.22),
        (0.0, 0.0, hip - 0.06),
        (0.01, 0.0, hip + 0.58),
        (0.03, 0.0, hip + 0.72),
        (-0.17, 0.0, hip + 0.34),
    ]


def _in_map(places_m: Floats, people: Sequence[MovingPerson]) -> Floats:
    """(people, N, 3) of each one's own frame to the map frame."""
    foot_x, foot_y, c, s = np.array([(p.x_m, p.y_m, cos(p.heading_rad), sin(p.heading_rad)) for p in people]).T[:, :, None]
    x, y = places_m[..., 0], places_m[..., 1]
    return np.stack((foot_x + c * x - s * y, foot_y + s * x + c * y, places_m[..., 2]), axis=-1)


def _capsules(view: View, camera_m: Floats, radii_m: Floats) -> tuple[Floats, Flags]:
    """Outlines (..., 2 * _ROUND, 2) in pixels of limbs (..., 2 ends, 3), and which of them lie before the near plane."""
    visible: Flags = camera_m[..., 2].min(axis=-1) >= NEAR_M
    safe = np.where(visible[..., None, None], camera_m, (0.0, 0.0, 1.0))
    pixels = view.to_pixels(safe)
    radii = radii_m * view.focal_px / safe[..., 2]
    way = pixels[..., 1, :] - pixels[..., 0, :]
    turn = np.arctan2(way[..., 1], way[..., 0])[..., None] + _HALF_TURN
    front = np.stack((np.cos(turn), np.sin(turn)), axis=-1)
    tip, tail = (pixels[..., k, None, :] + sign * radii[..., k, None, None] * front for k, sign in ((1, 1.0), (0, -1.0)))
    return np.concatenate((tip, tail), axis=-2), visible


def _lit(outlines: Floats) -> Floats:
    """Within each outline a narrower one, moved towards the sun."""
    middle = outlines.mean(axis=-2, keepdims=True)
    wide = outlines[..., 0].max(axis=-1) - outlines[..., 0].min(axis=-1)
    lit: Floats = (outlines - middle) * (0.60, 0.92) + middle + wide[..., None, None] * (0.08, 0.0)
    return lit


def _limb_patches(shapes: tuple[Corners, Corners], visible: list[bool], parts: list[Limb], detailed: bool) -> list[list[Patch]]:
    """Per limb its outline in shade and, seen from near, a lit part over it; nothing when not visible."""
    patches: list[list[Patch]] = []
    for outline, lit, part, is_visible in zip(*shapes, parts, visible, strict=True):
        if not is_visible:
            patches.append([])
        elif detailed:
            patches.append([(outline, shaded(part.colour, 0.74)), (lit, part.colour)])
        else:
            patches.append([(outline, shaded(part.colour, 0.9))])
    return patches


# half widths of chest, waist and hips: seen from the front, from the side
_BROAD_M = np.array([[0.215, 0.125], [0.165, 0.105], [0.165, 0.12]])
# right half of the torso from the neck down: which of chest, waist and hips, share of its half width, shares of DROP_M
_TORSO = ((0, 0.55, -0.9), (0, 0.92, -0.3), (0, 1.0, 0.5), (1, 1.0, 0.0), (2, 1.0, 0.0))
_TORSO_AT = np.array([part for part, _, _ in _TORSO] + [part for part, _, _ in reversed(_TORSO)])
_TORSO_WIDE = np.array([wide for _, wide, _ in _TORSO] + [-wide for _, wide, _ in reversed(_TORSO)])
_TORSO_DOWN = np.array([down for _, _, down in _TORSO] + [down for _, _, down in reversed(_TORSO)])
DROP_M = 0.09

_CIRCLE = np.stack((np.cos(np.arange(14) * (2 * pi / 14)), np.sin(np.arange(14) * (2 * pi / 14))), axis=1)
# ovals: which point of the trunk, half width, half height, and how far below that point its middle lies
_OVALS = {
    "bag": (5, 0.15, 0.21, 0.0),
    "neck": (3, 0.055, 0.09, 0.0),
    "hair": (4, 0.094, 0.118, -0.022),
    "far face": (4, 0.075, 0.09, 0.02),
    "face": (4, 0.073, 0.097, 0.022),
    "lit face": (4, 0.056, 0.083, 0.018),
}
_OVAL_AT = np.array([at for at, _, _, _ in _OVALS.values()])
_OVAL_RADII_M = np.array([(wide, high) for _, wide, high, _ in _OVALS.values()])
_OVAL_BELOW_M = np.array([below for _, _, _, below in _OVALS.values()])
_TURNS = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])  # a face seen from near lies on the side it looks to
_LIT_ASIDE_M = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.012])


@dataclass(frozen=True, slots=True)
class _Trunks:
    """Torso, head and bag of everybody, in corners."""

    torsos: Corners  # (people, 10, 2)
    lit_torsos: Corners
    ovals: Corners  # (people, _OVALS, 14, 2)
    away: list[float]  # how far each looks away from the camera, 1 to -1
    visible: list[bool]

    def patches(self, number: int, looks: Looks, detailed: bool) -> list[Patch]:
        if not self.visible[number]:
            return []
        ovals = dict(zip(_OVALS, self.ovals[number], strict=True))
        away = self.away[number]
        torso, lit = self.torsos[number], self.lit_torsos[number]
        body = [(torso, shaded(looks.shirt, 0.78)), (lit, looks.shirt)] if detailed else [(torso, shaded(looks.shirt, 0.92))]
        bag = [(ovals["bag"], shaded(looks.trousers, 0.7))] if looks.has_bag else []
        head = [(ovals["neck"], shaded(looks.skin, 0.78)), (ovals["hair"], looks.hair)]
        if away > 0.5:
            face = []
        elif detailed:
            face = [(ovals["face"], shaded(looks.skin, 0.86)), (ovals["lit face"], looks.skin)]
        else:
            face = [(ovals["far face"], looks.skin)]
        return (bag + body if away < 0.2 else body + bag) + head + face


def _trunks(view: View, camera_m: Floats, people: Sequence[MovingPerson], scale: Floats) -> _Trunks:
    """`camera_m`: (people, 6, 3), the points of `_trunk`."""
    visible: Flags = camera_m[..., 2].min(axis=1) >= NEAR_M
    safe = np.where(visible[:, None, None], camera_m, (0.0, 0.0, 1.0))
    pixels, per_m = view.to_pixels(safe), scale[:, None] * view.focal_px / safe[..., 2]
    ahead = np.array([(cos(person.heading_rad), sin(person.heading_rad), 0.0) for person in people]) @ view.axes.T
    broad = np.abs(ahead[:, 2:])  # 1 seen from the front or from behind, 0 from the side
    half = np.sqrt((_BROAD_M[:, 0] * broad) ** 2 + _BROAD_M[:, 1] ** 2 * (1 - broad**2)) * per_m[:, :3]
    torsos = pixels[:, _TORSO_AT]
    torsos[..., 0] += half[:, _TORSO_AT] * _TORSO_WIDE
    torsos[..., 1] += DROP_M * per_m[:, :1] * _TORSO_DOWN
    middle = (pixels[:, :1] + pixels[:, 2:3]) / 2
    lit = (torsos - middle) * (0.66, 0.97) + middle
    lit[..., 0] += 0.22 * half[:, 1:2]
    at, size = pixels[:, _OVAL_AT], per_m[:, _OVAL_AT]
    at[..., 0] += size * (0.035 * ahead[:, :1] * _TURNS + _LIT_ASIDE_M)
    at[..., 1] += size * _OVAL_BELOW_M
    ovals = at[:, :, None] + _CIRCLE * (size[..., None] * _OVAL_RADII_M)[:, :, None]
    return _Trunks(fixed(torsos), fixed(lit), fixed(ovals), ahead[:, 2].tolist(), visible.tolist())


_SHADOW_TIP_M = np.array(shadow_offset_m(STATURE_M))
_SHADOW_REACH_M = float(np.hypot(_SHADOW_TIP_M[0], _SHADOW_TIP_M[1]))
_SHADOW_FRAME = np.array([_SHADOW_TIP_M, (-_SHADOW_TIP_M[1], _SHADOW_TIP_M[0])]) / _SHADOW_REACH_M
_SPOT_M = (_CIRCLE * (0.26, 0.2)) @ _SHADOW_FRAME


def _shadows(view: View, people: Sequence[MovingPerson], scale: Floats) -> list[list[tuple[Floats, float]]]:
    """Per person a long shadow on the ground and, to be drawn seen from near, a darker spot under the feet."""
    size = scale[:, None, None]
    along = _CIRCLE * np.concatenate((size * _SHADOW_REACH_M / 2 + 0.1, np.full_like(size, 0.2)), axis=2)
    rings = np.zeros((len(people), 2, len(_CIRCLE), 3))
    rings[:, 0, :, :2] = along @ _SHADOW_FRAME + size * _SHADOW_TIP_M / 2
    rings[:, 1, :, :2] = _SPOT_M
    rings[..., :2] += np.array([(person.x_m, person.y_m) for person in people])[:, None, None]
    camera = view.to_camera(rings)
    visible = (camera[..., 2].min(axis=2) >= NEAR_M).tolist()
    camera[..., 2] = np.maximum(camera[..., 2], NEAR_M)
    pixels = view.to_pixels(camera)
    return [
        [(ring, share) for ring, share, is_visible in zip(own, (FULL_SHADE / 255, 0.30), seen, strict=True) if is_visible]
        for own, seen in zip(pixels, visible, strict=True)
    ]
