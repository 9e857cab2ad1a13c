"""What is remembered of a pure function: the last answer, and only for the very same objects."""

from vehicle_gateway.remembered import remembered


def test_a_function_is_asked_again_only_about_other_objects_and_an_equal_one_is_another():
    asked = []

    @remembered
    def total(numbers: list[int], more: list[int]) -> int:
        asked.append((numbers, more))
        return sum(numbers) + sum(more)

    one, other = [1, 2], [1, 2]
    assert [total(one, one), total(one, one)] == [6, 6]
    assert len(asked) == 1
    assert total(other, one) == total(one, other) == 6
    assert len(asked) == 3
    assert total(one, other) == 6
    assert len(asked) == 3
    assert total([1], [2]) == 3


def test_nothing_is_remembered_of_a_question_that_failed():
    answers = iter([None, 5])

    @remembered
    def answer(_: object) -> int:
        found = next(answers)
        if found is None:
            raise ValueError
        return found

    question = object()
    try:
        answer(question)
    except ValueError:
        assert answer(question) == answer(question) == 5
