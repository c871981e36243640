"""Codes that the second opinions share: how a motion that they follow ends, its events, and their digits."""

TIME_REACHED = 0  # the end of the motion that was asked for
EVENTS_FULL = 1  # the arrays for the events are
AMBIGUOUS = 2  # the digits do not suffice to tell what comes next
SETTLED = 3  # no further event can come
SLOW = 4  # the next event comes after more turns than the phase is known for
LATE = 5  # it took more strides than are allowed

DIGITS = 40  # in which the constants of a drive are formed before they are rounded

# Names of the events of the rigid drive in the order of their codes, as the references have them.
KINDS = ("contact_reversal", "stick", "reversal", "release", "seizure")
CONTACT_REVERSAL, STICK, REVERSAL, RELEASE, SEIZURE = range(5)

HALVINGS = 60  # of a bracket: what is left of it is below the last digit of a double
