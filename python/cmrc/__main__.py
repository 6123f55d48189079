"""``python -m cmrc``."""

import sys

from cmrc.commands import main

if __name__ == "__main__":
    sys.exit(main())
