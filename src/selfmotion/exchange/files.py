"""Writing files whole or not at all, and never over somebody else's work."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from selfmotion._checks import is_file_name
from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError
from selfmotion.units import UNITS as UNITS  # noqa: PLC0414 (where readers of files look for them)

MANIFEST = ".selfmotion.json"
"""Lists what selfmotion wrote into a folder, with checksums: only that may be replaced unasked."""


class OutputFolder:
    """A folder that results are written to.

    Parameters
    ----------
    path : path-like
        Made when the first file is written.
    force : bool
        Whether files that selfmotion did not write, or that were changed since, may be replaced.

    Raises
    ------
    InvalidInputError
        If the path is no name of a folder.
    """

    def __init__(self, path: str | os.PathLike[str], force: bool = False) -> None:
        if not os.fspath(path) or not is_file_name(os.fspath(path)):
            raise InvalidInputError("--out", "is no name of a folder", "name one", str(path))
        self.path = Path(path)
        self.force = force

    def check(self, names: Iterable[str]) -> None:
        """Refuse early what :meth:`write` would refuse.

        Raises
        ------
        InvalidInputError
            If the path is not a folder, cannot be written to, or holds a foreign file of one of these names.
        """
        try:
            if self.path.exists() and not self.path.is_dir():
                raise InvalidInputError("--out", f"{self.path} is not a folder", "name a folder")
            above = next(folder for folder in (self.path, *self.path.absolute().parents) if folder.exists())
            if not above.is_dir() or not os.access(above, os.W_OK):
                raise InvalidInputError("--out", f"{self.path} cannot be written to", "name another folder")
            known = self._manifest()
            for name in names:
                target = self.path / name
                if target.is_dir():
                    raise InvalidInputError("--out", f"{target} is a folder", "move it away or name another folder")
                if self.force or not target.exists():
                    continue
                if known.get(name) != _checksum(target.read_bytes()):
                    raise InvalidInputError(
                        "--out", f"{target} is not what selfmotion wrote", "add --force to replace it"
                    )
        except OSError as error:
            raise _cannot_write(self.path, error) from None

    def write(self, contents: Mapping[str, bytes], outdated: Iterable[str] = ()) -> list[Path]:
        """Write files, each whole or not at all.

        Parameters
        ----------
        contents : mapping
            File name to bytes.
        outdated : iterable of str
            Names of files of an earlier run that these results contradict; removed if selfmotion wrote them.

        Returns
        -------
        list of Path
            What was written.

        Raises
        ------
        InvalidInputError
            As :meth:`check`, or if the disk refuses.
        """
        self.check(contents)
        staged: list[tuple[Path, str]] = []
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            manifest = self._manifest()
            gone = set(outdated) - set(contents)
            gone = {name for name in gone if manifest.pop(name, None) == _checksum_of(self.path / name)}
            manifest.update({name: _checksum(data) for name, data in contents.items()})
            record = json.dumps({"generator": f"selfmotion {__version__}", "files": manifest}, indent=1)
            for name, data in [*contents.items(), (MANIFEST, record.encode())]:
                staged.append((self._stage(data), name))
            for temporary, name in staged:
                os.replace(temporary, self.path / name)
            for name in gone:
                (self.path / name).unlink()
        except OSError as error:
            raise _cannot_write(self.path, error) from None
        finally:
            for leftover, _ in staged:  # nobody else's: another run may be writing here too
                leftover.unlink(missing_ok=True)
        return [self.path / name for name in contents]

    def _stage(self, data: bytes) -> Path:
        handle, name = tempfile.mkstemp(prefix=".selfmotion-", suffix=".tmp", dir=self.path)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(name, 0o666 & ~_umask())
        except OSError:
            os.unlink(name)
            raise
        return Path(name)

    def _manifest(self) -> dict[str, str]:
        try:
            record = json.loads((self.path / MANIFEST).read_text(encoding="utf-8"))
            return {str(name): str(checksum) for name, checksum in record["files"].items()}
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return {}


def write_file(file: str | os.PathLike[str], data: bytes, force: bool = False) -> None:
    """Write one file whole or not at all, by the rules of :class:`OutputFolder` for its folder.

    Raises
    ------
    InvalidInputError
        If it is there and not selfmotion's, without `force`, or the disk refuses.
    """
    folder, name = checked_target(file, force)
    folder.write({name: data})


def checked_target(file: str | os.PathLike[str], force: bool = False) -> tuple[OutputFolder, str]:
    """Return the folder and the name of a file to be written; refuse early what :func:`write_file` would refuse."""
    path = os.fspath(file)
    name = os.path.basename(path)
    if not name or name in (".", "..", MANIFEST):
        raise InvalidInputError("--out", "is no name of a file", "name one", path)
    folder = OutputFolder(os.path.dirname(path) or ".", force)
    folder.check([name])
    return folder, name


def read_text(file: str | os.PathLike[str], largest: int = 200_000_000) -> str:
    """Return the text of a UTF-8 file.

    Raises
    ------
    InvalidInputError
        If it cannot be read, is larger than `largest` bytes, or is not text.
    """
    return as_text(read_bytes(file, largest), os.fspath(file))


def as_text(data: bytes, source: str) -> str:
    """Return the text of a UTF-8 file that was read.

    Raises
    ------
    InvalidInputError
        If it is not text.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInputError("", "is not a UTF-8 text file", "is it the right file?", source=source) from None


def read_bytes(file: str | os.PathLike[str], largest: int = 200_000_000) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    InvalidInputError
        If it cannot be read or is larger than `largest` bytes.
    """
    path, source = Path(file), os.fspath(file)
    if not is_file_name(source):
        raise InvalidInputError("", "is no name of a file", "name one", source)
    try:
        if path.is_dir():
            raise IsADirectoryError
        too_large = path.stat().st_size > largest
        with path.open("rb") as stream:
            data = b"" if too_large else stream.read(largest + 1)  # of a device the size says nothing
        if too_large or len(data) > largest:
            raise InvalidInputError("", f"is larger than {largest} bytes", "is it the right file?", source=source)
        return data
    except IsADirectoryError:
        raise InvalidInputError("", "is a folder", "name a file", source=source) from None
    except FileNotFoundError:
        raise InvalidInputError("", "does not exist", "check the name", source=source) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InvalidInputError("", f"cannot be read ({reason})", "check the file", source=source) from None


def _cannot_write(path: Path, error: OSError) -> InvalidInputError:
    reason = error.strerror or str(error)
    return InvalidInputError("--out", f"{path} cannot be written to ({reason})", "name another folder")


def _checksum(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _checksum_of(file: Path) -> str:
    return _checksum(file.read_bytes()) if file.is_file() else ""


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
