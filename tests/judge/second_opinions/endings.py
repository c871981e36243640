"""Codes that the second opinions share: how a motion that they follow ends."""

TIME_REACHED = 0  # the end of the motion that was asked for
EVENTS_FULL = 1  # the arrays for the events are
AMBIGUOUS = 2  # the digits do not suffice to tell what comes next
SETTLED = 3  # no further event can come
SLOW = 4  # the next event comes after more turns than the phase is known for
LATE = 5  # it took more strides than are allowed
