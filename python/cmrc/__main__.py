"""``python -m cmrc``."""

import sys

from cmrc import early_signals

if __name__ == "__main__" or early_signals.is_command():
    early_signals.handle()

from cmrc.commands import main

if __name__ == "__main__":
    sys.exit(main())
