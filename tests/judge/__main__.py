"""``PYTHONPATH=tests python -m judge``: draw random drives and judge what the program says about each of them."""

import sys

from judge.command import main

if __name__ == "__main__":
    sys.exit(main())
