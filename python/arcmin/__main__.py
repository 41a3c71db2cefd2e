"""``python -m arcmin`` is the ``arcmin`` command."""

import sys

from arcmin._cli import main

if __name__ == "__main__":
    sys.exit(main())
