"""People on foot: a skeleton that walks with the gait's phase, dressed and drawn limb by limb. True perspective.

Proportions after common anthropometric tables (50th percentile, stature 1.75 m); the gait is a plain pendulum with a bent
knee in the swing, the feet stay on the ground. Not modelled: faces, wind, standing at rest other than upright.
"""

from dataclasses import dataclass
from math import cos, pi, sin

import cv2
import numpy as np

from vehicle_gateway.video.render.brush import SHIFT, Colour, darken, fixed, shaded
from vehicle_gateway.video.render.projection import NEAR_M, Flags, Floats, Picture, View
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


Patch = tuple[Floats, Colour]  # a convex polygon in pixels


def draw_person(canvas: Picture, view: View, person: MovingPerson, looks: Looks) -> None:
    """Nothing when the person stands beside or behind the camera's plane; limbs that cross it are left out."""
    foot = view.to_camera((person.x_m, person.y_m, 0.0))
    if foot[2] < NEAR_M:
        return
    detailed = STATURE_M * view.focal_px / float(foot[2]) > DETAIL_PX
    _shade(canvas, view, person, looks, detailed)
    patches = _patches(view, person, looks, detailed)
    if patches:
        corners = fixed(np.concatenate([shape for shape, _ in patches]))
        ends = np.cumsum([len(shape) for shape, _ in patches]).tolist()
        for first, last, (_, colour) in zip([0, *ends], ends, patches, strict=False):
            cv2.fillConvexPoly(canvas, corners[first:last], colour, cv2.LINE_AA, SHIFT)


def _patches(view: View, person: MovingPerson, looks: Looks, detailed: bool) -> list[Patch]:
    """Everything to fill, in order: what is behind the torso, torso and head, the near arm."""
    parts = limbs(person.phase, person.speed_m_s, looks)
    places = np.array([end for part in parts for end in (part.start_m, part.end_m)] + _trunk(parts))
    camera = view.to_camera(_in_map(places * looks.scale, person))
    count = len(parts)
    radii = np.array([(part.start_radius_m, part.end_radius_m) for part in parts]) * looks.scale
    ends = camera[: 2 * count].reshape(-1, 2, 3)
    limb_patches = _limbs(_capsules(view, ends, radii), parts, detailed)
    depth = ends[:, :, 2].mean(axis=1)
    torso_m = float(camera[2 * count, 2])
    behind: list[Patch] = []
    before: list[Patch] = []
    for i in np.argsort(-depth).tolist():
        is_near_arm = i >= count - ARM_PARTS and depth[i] <= torso_m  # legs end under the shirt
        (before if is_near_arm else behind).extend(limb_patches[i])
    return behind + _torso_and_head(view, camera[2 * count :], person, looks, detailed) + before


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


def _in_map(places_m: Floats, person: MovingPerson) -> Floats:
    c, s = cos(person.heading_rad), sin(person.heading_rad)
    x, y = places_m[:, 0], places_m[:, 1]
    return np.stack((person.x_m + c * x - s * y, person.y_m + s * x + c * y, places_m[:, 2]), axis=1)


def _capsules(view: View, camera_m: Floats, radii_m: Floats) -> Floats:
    """Outlines (N, 2 * _ROUND, 2) in pixels of limbs (N, 2 ends, 3); NaN for one that reaches behind the near plane."""
    visible: Flags = camera_m[..., 2].min(axis=1) >= NEAR_M
    safe = np.where(visible[:, None, None], camera_m, (0.0, 0.0, 1.0))
    pixels = view.to_pixels(safe)
    radii = radii_m * view.focal_px / safe[..., 2]
    way = pixels[:, 1] - pixels[:, 0]
    turn = np.arctan2(way[:, 1], way[:, 0])[:, None] + _HALF_TURN
    front = np.stack((np.cos(turn), np.sin(turn)), axis=-1)
    outline = np.concatenate(
        (pixels[:, 1, None] + radii[:, 1, None, None] * front, pixels[:, 0, None] - radii[:, 0, None, None] * front), axis=1
    )
    outline[~visible] = np.nan
    return outline


def _limbs(shapes: Floats, parts: list[Limb], detailed: bool) -> list[list[Patch]]:
    """Per limb its outline in shade and, seen from near, a narrower lit part over it; nothing when not visible."""
    middle = shapes.mean(axis=1, keepdims=True)
    aside = (shapes[..., 0].max(axis=1) - shapes[..., 0].min(axis=1))[:, None, None] * (0.08, 0.0)
    lit = (shapes - middle) * (0.60, 0.92) + middle + aside
    hidden = np.isnan(shapes[:, 0, 0]).tolist()
    patches: list[list[Patch]] = []
    for shape, bright, part, is_hidden in zip(shapes, lit, parts, hidden, strict=True):
        if is_hidden:
            patches.append([])
        elif detailed:
            patches.append([(shape, shaded(part.colour, 0.74)), (bright, part.colour)])
        else:
            patches.append([(shape, shaded(part.colour, 0.9))])
    return patches


def _torso_and_head(view: View, camera_m: Floats, person: MovingPerson, looks: Looks, detailed: bool) -> list[Patch]:
    if float(camera_m[:, 2].min()) < NEAR_M:
        return []
    pixels = view.to_pixels(camera_m)
    per_m = (looks.scale * view.focal_px / camera_m[:, 2]).tolist()
    ahead = (view.axes @ (cos(person.heading_rad), sin(person.heading_rad), 0.0)).tolist()
    bag = _oval(pixels[5], 0.15 * per_m[5], 0.21 * per_m[5], shaded(looks.trousers, 0.7))
    neck = _oval(pixels[3], 0.055 * per_m[3], 0.09 * per_m[3], shaded(looks.skin, 0.78))
    bag_is_behind = ahead[2] < 0.2
    return [
        *([bag] if looks.has_bag and bag_is_behind else []),
        *_torso(pixels, per_m, abs(ahead[2]), looks, detailed),
        *([bag] if looks.has_bag and not bag_is_behind else []),
        neck,
        *_head(pixels[4], per_m[4], ahead, looks, detailed),
    ]


# half widths of chest, waist and hips: seen from the front, from the side
_BROAD_M = ((0.215, 0.125), (0.165, 0.105), (0.165, 0.12))


def _torso(pixels: Floats, per_m: list[float], broad: float, looks: Looks, detailed: bool) -> list[Patch]:
    """`broad`: 1 seen from the front or from behind, 0 from the side."""
    (x0, y0), (x1, y1), (x2, y2) = pixels[:3].tolist()
    w0, w1, w2 = (((b * broad) ** 2 + d * d * (1 - broad * broad)) ** 0.5 * per_m[k] for k, (b, d) in enumerate(_BROAD_M))
    drop = 0.09 * per_m[0]
    outline = np.array(
        [
            (x0 + 0.55 * w0, y0 - 0.9 * drop),
            (x0 + 0.92 * w0, y0 - 0.3 * drop),
            (x0 + w0, y0 + 0.5 * drop),
            (x1 + w1, y1),
            (x2 + w2, y2),
            (x2 - w2, y2),
            (x1 - w1, y1),
            (x0 - w0, y0 + 0.5 * drop),
            (x0 - 0.92 * w0, y0 - 0.3 * drop),
            (x0 - 0.55 * w0, y0 - 0.9 * drop),
        ]
    )
    if not detailed:
        return [(outline, shaded(looks.shirt, 0.92))]
    middle = np.array([(x0 + x2) / 2, (y0 + y2) / 2])
    lit = (outline - middle) * (0.66, 0.97) + middle + (0.22 * w1, 0.0)
    return [(outline, shaded(looks.shirt, 0.78)), (lit, looks.shirt)]


def _head(middle_px: Floats, per_m: float, ahead: list[float], looks: Looks, detailed: bool) -> list[Patch]:
    hair = _oval(middle_px - (0.0, 0.022 * per_m), 0.094 * per_m, 0.118 * per_m, looks.hair)
    if -ahead[2] < -0.5:  # looks away from the camera
        return [hair]
    if not detailed:
        return [hair, _oval(middle_px + (0.0, 0.02 * per_m), 0.075 * per_m, 0.09 * per_m, looks.skin)]
    face = middle_px + (ahead[0] * 0.035 * per_m, 0.022 * per_m)
    return [
        hair,
        _oval(face, 0.073 * per_m, 0.097 * per_m, shaded(looks.skin, 0.86)),
        _oval(face + (0.012 * per_m, -0.004 * per_m), 0.056 * per_m, 0.083 * per_m, looks.skin),
    ]


_CIRCLE = np.stack((np.cos(np.arange(14) * (2 * pi / 14)), np.sin(np.arange(14) * (2 * pi / 14))), axis=1)


def _oval(middle_px: Floats, wide_px: float, high_px: float, colour: Colour) -> Patch:
    return middle_px + _CIRCLE * (wide_px, high_px), colour


def _shade(canvas: Picture, view: View, person: MovingPerson, looks: Looks, detailed: bool) -> None:
    """A long shadow on the ground and, seen from near, a darker spot under the feet."""
    foot = np.array([person.x_m, person.y_m])
    tip = np.array(shadow_offset_m(STATURE_M * looks.scale))
    reach = float(np.hypot(tip[0], tip[1]))
    frame = np.array([tip, (-tip[1], tip[0])]) / reach
    ovals = [(foot + tip / 2, (reach / 2 + 0.1, 0.2), FULL_SHADE / 255)]
    if detailed:
        ovals.append((foot, (0.26, 0.2), 0.30))
    for middle, radii, share in ovals:
        ring = np.concatenate((middle + (_CIRCLE * radii) @ frame, np.zeros((len(_CIRCLE), 1))), axis=1)
        camera = view.to_camera(ring)
        if float(camera[:, 2].min()) >= NEAR_M:
            darken(canvas, view.to_pixels(camera), share)
