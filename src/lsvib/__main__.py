"""``python -m lsvib``: the command, where its script is not on the path."""

from lsvib.cli.app import main

if __name__ == "__main__":
    main()
