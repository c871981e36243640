"""From a data sheet to a verdict: will a lead-screw drive vibrate, how close is it, and what should be changed."""
