"""How a motion ends that :mod:`lsvib.bench.second_opinions.watch` or :mod:`lsvib.bench.second_opinions.strides`
follows, and their digits."""

TIME_REACHED = 0
EVENTS_FULL = 1  # the arrays for the events are
AMBIGUOUS = 2  # the digits do not suffice to tell what comes next
SETTLED = 3  # no further event can come
SLOW = 4  # the next event comes after more turns than the phase is known for
LATE = 5  # it took more strides than are allowed

DIGITS = 40  # in which the constants of a drive are formed before they are rounded
