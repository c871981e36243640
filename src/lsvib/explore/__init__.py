"""A page in the browser on which drives can be explored; only the command ``lsvib explore`` loads this room."""
