"""For how long a condition has lasted: a moment without it takes twice its time back."""

from __future__ import annotations

from mission.engine.lasting import Lasting


def test_what_holds_without_a_break_lasts_from_its_beginning_on() -> None:
    lasting = Lasting()
    assert [lasting.holds("a", now) for now in (1.25, 2.0, 90.0)] == [1.25] * 3
    assert lasting.holds("b", 3.0) == 3.0


def test_a_break_takes_twice_its_time_back_and_never_more_than_there_is() -> None:
    lasting = Lasting()
    lasting.holds("a", 0.0)
    lasting.breaks("a", 10.0)
    lasting.breaks("a", 10.5)
    assert lasting.holds("a", 11.0) == 3.0  # 1 s of break, and 2 s for it
    assert lasting.holds("a", 12.0) == 3.0
    lasting.breaks("a", 13.0)
    assert lasting.holds("a", 18.0) == 18.0


def test_a_break_as_long_as_half_of_what_was_ends_it() -> None:
    lasting = Lasting()
    lasting.holds("a", 0.0)
    lasting.breaks("a", 10.0)
    lasting.breaks("a", 14.0)
    assert lasting
    lasting.breaks("a", 15.0)
    assert not lasting


def test_time_in_which_nobody_could_tell_counts_neither_way() -> None:
    lasting = Lasting()
    lasting.holds("a", 0.0)
    lasting.unseen("a", 100.0)
    assert lasting.holds("a", 101.0) == 100.0
    lasting.breaks("a", 110.0)
    lasting.unseen("a", 50.0)
    assert lasting.holds("a", 161.0) == 153.0  # 1 s of break, and 2 s for it
    lasting.unseen("b", 50.0)
    assert lasting.holds("b", 162.0) == 162.0


def test_what_never_held_does_not_end() -> None:
    lasting = Lasting()
    lasting.breaks("a", 1.0)
    assert lasting.holds("a", 2.0) == 2.0


def test_only_what_is_kept_goes_on() -> None:
    lasting = Lasting()
    for name in ("a", "b"):
        lasting.holds(name, 0.0)
    lasting.keep({"b", "c"})
    assert (lasting.holds("a", 5.0), lasting.holds("b", 5.0)) == (5.0, 0.0)


def test_a_copy_goes_its_own_way() -> None:
    lasting = Lasting()
    lasting.holds("a", 0.0)
    copy = lasting.clone()
    copy.forget("a")
    assert (bool(copy), lasting.holds("a", 4.0)) == (False, 0.0)
