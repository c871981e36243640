"""From measured torque over speed to the friction law of the threads and the drag of the bearings."""
