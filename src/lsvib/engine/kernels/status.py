"""The numbers that kernels return to say how a run of the engine has ended; they never raise."""

from enum import IntEnum


class Status(IntEnum):
    """How a run ended."""

    TIME_REACHED = 0  # the requested end time
    STOP_EVENT = 1  # the event that the caller asked for
    SETTLED = 2  # no guard can ever fire again: the motion stays in its mode for ever
    EVENTS_FULL = 3  # the caller's event list is full; the run can go on from its last state
    DIVERGED = 4  # the state left the range of numbers
    ACCUMULATED = 5  # infinitely many events in finite time, and the model names no mode beyond them
    NO_BRANCH = 6  # a transition whose conditions exclude each other: the model is incomplete
    UNDECIDED = 7  # the search for the next event did not come to an end
    WORK_SPENT = 8  # the search for the next event took all steps that it was allowed


class Found(IntEnum):
    """What the search for a root of one guard found."""

    NONE = 0
    CROSSING = 1
    GRAZE = 2
    UNDECIDED = 3  # the search did not come to an end


class Decision(IntEnum):
    """What is proved of a guard on one step of the search; of several guards the largest number counts."""

    POSITIVE = 0  # no root
    TOUCHES = 1  # zero to rounding
    ROOT = 2  # one root
    UNDECIDED = 3


class Test(IntEnum):
    """Sign test of an affine function of the state; 'zero' means zero to rounding."""

    POSITIVE = 0
    NOT_NEGATIVE = 1
    ZERO = 2


# Event kinds. The engine itself writes the first two; models number theirs from FIRST_MODEL_KIND on.
GRAZE_KIND = 0  # a guard is touched, not crossed
ACCUMULATION_KIND = 1  # infinitely many events in finite time end here
FIRST_MODEL_KIND = 2
