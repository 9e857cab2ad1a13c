"""Names of classes: whoever means the same keeps its name, though people come, go and are passed."""

from math import pi

from autonomy.planning.guidance.identities import REMEMBERED, known_now, name, remembered
from autonomy.planning.guidance.state import Code, KnownClass
from autonomy.planning.guidance.winding import Side

L, R, N = Side.LEFT, Side.RIGHT, Side.NON_PASSING


def code(**sides: Side) -> Code:
    return tuple((ord(who), side) for who, side in sides.items())


def known(*codes: Code) -> tuple[KnownClass, ...]:
    return tuple(KnownClass(identity=10 + place, code=each) for place, each in enumerate(codes))


def test_equal_codes_keep_their_names_in_any_order() -> None:
    before = known(code(a=L, b=N), code(a=R, b=N), code(a=N, b=N))
    assert name((code(a=N, b=N), code(a=L, b=N), code(a=R, b=N)), before, 50) == ((12, 10, 11), 50)


def test_who_comes_and_who_goes_changes_no_name() -> None:
    before = known(code(a=L, b=R), code(a=R, b=R))
    assert name((code(b=R, a=R, c=L), code(a=L, c=N)), before, 50) == ((11, 10), 50)


def test_another_side_is_another_class() -> None:
    assert name((code(a=L),), known(code(a=R)), 50) == ((50,), 51)


def test_one_name_is_given_once_and_to_the_better_one() -> None:
    assert name((code(a=L, c=L), code(a=L, c=R)), known(code(a=L)), 50) == ((10, 50), 51)


def test_somebody_whom_the_horizon_reaches_gives_the_name_to_the_best_that_does_not_contradict() -> None:
    assert name((code(a=L, b=R), code(a=L, b=L)), known(code(a=L, b=N)), 50) == ((10, 50), 51)
    assert name((code(a=L, b=R), code(a=L, b=N)), known(code(a=L, b=N)), 50) == ((50, 10), 51)  # unless one agrees


def test_somebody_whom_the_car_has_passed_on_the_left_is_passed_no_more() -> None:
    before = known(code(a=L, b=R), code(a=N, b=R))
    seen = known_now(before, ((ord("a"), pi / 2 + 0.1), (ord("b"), pi)), ((ord("a"), pi / 2 - 0.1), (ord("b"), pi + 0.1)))
    assert [each.code for each in seen] == [code(a=N, b=R), code(a=R, b=R)]
    assert name((code(a=N, b=R),), seen, 50) == ((10,), 50)


def test_a_bearing_that_goes_from_one_end_of_its_range_to_the_other_is_no_turn() -> None:
    """Just ahead to the right is -89 degrees, just behind to the right 269."""
    before = known(code(a=R))
    seen = known_now(before, ((ord("a"), 1.5 * pi - 0.01),), ((ord("a"), -0.5 * pi + 0.01),))
    assert [each.code for each in seen] == [code(a=N)]  # passed on the right


def test_a_class_that_chance_misses_is_remembered_for_a_while() -> None:
    classes = known(code(a=L))
    for _ in range(REMEMBERED):
        classes = remembered((), classes)
        assert name((code(a=L),), classes, 50) == ((10,), 50)
        assert name((code(b=L, a=N),), classes, 50) == ((50,), 51)  # but not for something that is only alike
    assert remembered((), classes) == ()
