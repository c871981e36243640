"""The ``lsvib`` command, one module for each subject; a module here that uses ``app.command`` adds a command."""
