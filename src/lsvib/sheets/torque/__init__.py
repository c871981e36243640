"""From tables and records of torque to the friction law of the threads and the drag of the bearings."""
