"""Somebody, or something, as the tracker tells of them after it has seen them for a while."""

from dataclasses import replace

from autonomy.perception.tracking import Track


def seen(
    x_m: float, y_m: float, vx_m_s: float = 0.0, vy_m_s: float = 0.0, kind: str = "person", number: int = 1, **changes: object
) -> Track:
    """Who does not move has never been seen to; `changes`: of any field."""
    track = Track(
        number=number,
        stamp_ns=0,
        born_ns=0,
        x_m=x_m,
        y_m=y_m,
        velocity_x_m_s=vx_m_s,
        velocity_y_m_s=vy_m_s,
        position_variance=0.004,
        cross_variance=0.004,
        velocity_variance=0.02,
        radius_m=0.3,
        votes=((kind, 9),),
        hits=9,
        confirmed=True,
        static=vx_m_s == vy_m_s == 0.0,
    )
    return replace(track, **changes)  # type: ignore[arg-type]
