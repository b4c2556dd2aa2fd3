"""Says whether the locked requirements are for this Python and system, and if not, what is done instead."""

import platform
import sys

ours = f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
tried = sys.version_info[:2] in ((3, 11), (3, 12), (3, 13)) and platform.system() == "Linux"
if not (tried and platform.machine() == "x86_64" and platform.libc_ver()[0] == "glibc"):
    sys.exit(f"{ours}: the lock is for Python 3.11 to 3.13 on Linux x86_64; installing the newest releases, unlocked.")
