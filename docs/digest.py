"""Whether what a build made before is still good: a digest of the code that made it."""

import hashlib
from pathlib import Path

import selfmotion


def digest(source: Path):
    """Return a digest of `source` and of the whole package."""
    sources = [source, *sorted(Path(selfmotion.__file__).parent.rglob("*.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()
