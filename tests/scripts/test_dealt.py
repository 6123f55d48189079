"""The order of the tests for several workers."""

import pytest
from dealt import dealt

FILES = {"a": 5, "b": 1, "c": 40, "d": 3, "e": 2, "f": 30, "g": 1, "h": 18}
TESTS = [(file, number) for file, count in FILES.items() for number in range(count)]
SLOW = {("b", 0), ("d", 2), ("e", 0), ("g", 0)}


@pytest.mark.parametrize("workers", [2, 3, 4, 16])
def test_no_test_is_lost_and_those_of_a_file_stay_together_in_their_order(workers: int) -> None:
    order = dealt(TESTS, workers, file_of=lambda test: test[0], is_slow=SLOW.__contains__)
    assert sorted(order) == TESTS
    for file in FILES:
        places = [place for place, test in enumerate(order) if test[0] == file]
        assert places == list(range(places[0], places[-1] + 1))
        assert [order[place][1] for place in places] == list(range(len(places)))


def test_each_worker_begins_with_files_that_have_slow_tests_and_the_list_ends_with_fast_ones() -> None:
    order = [file for file, _ in dealt(TESTS, 2, file_of=lambda test: test[0], is_slow=SLOW.__contains__)]
    assert list(dict.fromkeys(order)) == ["b", "e", "a", "c", "f", "d", "g", "h"]
    # A file is not cut: the second worker's part begins in the last file of the first one.
    assert order.index("d") == 78
    assert len(order) // 2 == 50


def test_without_a_slow_test_the_order_stays() -> None:
    assert dealt(TESTS, 2, file_of=lambda test: test[0], is_slow=lambda _: False) == TESTS
