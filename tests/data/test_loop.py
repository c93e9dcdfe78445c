from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.errors import BadInputError
from tests.data.samples import two_sided


def test_arrays_are_copies_that_cannot_be_written_to() -> None:
    torque, angle = two_sided()
    loop = Loop(torque, angle, time=np.arange(torque.size))
    torque[0] = 99.0
    assert loop.torque[0] == 0.0
    assert loop.time is not None
    assert loop.time.dtype == np.float64
    for values in (loop.torque, loop.angle, loop.time):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
    assert len(loop) == torque.size


def test_arrays_stay_read_only_through_pickling() -> None:
    back = pickle.loads(pickle.dumps(Loop(*two_sided(), warnings=("w",))))
    assert not back.torque.flags.writeable
    assert back.warnings == ("w",)


def test_time_starts_at_the_first_stamp() -> None:
    loop = Loop([1, 2, 3], [0, 0, 1], time=[10.0, 10.5, 12.0])
    assert loop.time is not None
    assert loop.time.tolist() == [0.0, 0.5, 2.0]


def test_repeated_times_leave_the_record_untimed() -> None:
    loop = Loop([1, 2, 3], [0, 0, 1], time=[0.0, 0.5, 0.5])
    assert loop.time is None
    assert "1 of 3 times repeat" in loop.warnings[0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"angle": [0.0, 1.0]}, "2 samples; expected 3 samples"),
        ({"torque": [1.0, np.nan, 2.0]}, "nan at sample 2"),
        ({"angle": [1.0, 2.0, np.inf]}, "inf at sample 3"),
        ({"time": [0.0, 2.0, 1.0]}, "1 s at sample 3 after 2 s"),
        ({"torque": [[1.0, 2.0, 3.0]]}, "shape"),
        ({"torque": [], "angle": []}, "shape"),
        ({"temperature": ["warm", "hot", "hot"]}, "not all numbers"),
    ],
)
def test_refusals(change: dict[str, Any], words: str) -> None:
    values: dict[str, Any] = {"torque": [1.0, 2.0, 3.0], "angle": [0.0, 0.0, 1.0], **change}
    with pytest.raises(BadInputError, match=words):
        Loop(**values, source="rig.csv")


@pytest.mark.parametrize("kind", ["datetime64[ns]", "timedelta64[us]", "timedelta64[s]"])
def test_dates_are_not_taken_for_seconds(kind: str) -> None:
    """Their counts, of nanoseconds or so, had passed for seconds."""
    torque, _ = two_sided()
    time = np.arange(torque.size).astype(kind)
    with pytest.raises(BadInputError, match=r"time: found values of type .* seconds\."):
        Loop(torque, torque / 1e4, time=time)


def test_what_is_masked_is_no_reading() -> None:
    torque, _ = two_sided()
    masked = np.ma.masked_array(torque / 1e4, np.arange(torque.size) == 6)
    with pytest.raises(BadInputError, match="angle: found nan at sample 7"):
        Loop(torque, masked)
    assert Loop(torque, np.ma.masked_array(torque)).angle[3] == torque[3]


def test_warnings_are_added_once() -> None:
    loop = Loop(*two_sided()).with_warnings(["a", "b"]).with_warnings(["b", "c"])
    assert loop.warnings == ("a", "b", "c")
