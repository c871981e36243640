"""What is saved by leaving out what a scene does not need."""
