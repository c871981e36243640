"""From a data sheet, or a measured torque, to a verdict: will the drive vibrate, and what should be changed."""
