"""``python -m lsvib.bench.random_drives``: draw random drives and judge what the program says about each of them."""

import sys

from lsvib.bench.random_drives.command import main

if __name__ == "__main__":
    sys.exit(main())
